//! Content of an ELF image: symbols and memory sections kept by the linker.

use anyhow::{Context, Result, ensure};
use object::{Object, ObjectSection, ObjectSymbol};
use serde_json::Value;
use std::path::Path;

/// Parts of symbol names that flight code must not contain: panics (slice index, unwrap, division by
/// zero, overflow), heap allocation, and double precision, which a Cortex-M4F emulates in software.
const UNWANTED: [&str; 7] =
    ["panicking", "panic_", "_failed", "rust_begin_unwind", "__rust_alloc", "__rg_", "__aeabi_d"];

/// Mangled names of all symbols of the image `elf`.
pub fn symbols(elf: &Path) -> Result<Vec<String>> {
    let bytes = read(elf)?;
    let file = parse(elf, &bytes)?;
    let names = file.symbols().filter_map(|symbol| symbol.name().ok().map(String::from));
    Ok(names.filter(|name| !is_log_text(name)).collect())
}

/// Addresses of the functions of the image `elf` with one of `names` in their mangled name.
pub fn functions(elf: &Path, names: &[&str]) -> Result<Vec<u32>> {
    let bytes = read(elf)?;
    let file = parse(elf, &bytes)?;
    let is_wanted = |name: &str| !is_log_text(name) && names.iter().any(|n| name.contains(n));
    let wanted = file.symbols().filter(|symbol| symbol.name().is_ok_and(is_wanted));
    // The lowest bit marks Thumb code.
    Ok(wanted.map(|symbol| symbol.address() as u32 & !1).collect())
}

/// A test of an image that is built with embedded-test.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BoardTest {
    /// Name.
    pub name: String,
    /// Address of its function.
    pub address: u32,
    /// It runs on request only.
    pub is_ignored: bool,
}

/// Tests of the image `elf`, in the order of their names: each is a variable in the section `.embedded_test` that begins
/// with the address of the function, and its symbol is a JSON object with name and properties.
///
/// # Errors
/// The file is not an image, or has a test without name or address.
pub fn board_tests(elf: &Path) -> Result<Vec<BoardTest>> {
    let bytes = read(elf)?;
    let file = parse(elf, &bytes)?;
    let section = file.section_by_name(".embedded_test").context("the image has no tests")?;
    let content = section.data().context("the section of the tests is not readable")?;
    let mut tests = Vec::new();
    for symbol in file.symbols().filter(|symbol| symbol.section_index() == Some(section.index())) {
        let Ok(properties) = serde_json::from_str::<Value>(symbol.name()?) else { continue };
        let name = properties["name"].as_str().context("a test has no name")?;
        let offset = usize::try_from(symbol.address() - section.address())?;
        let address = content.get(offset..).and_then(|rest| rest.first_chunk());
        tests.push(BoardTest {
            name: name.to_owned(),
            address: u32::from_le_bytes(*address.context("a test has no address")?),
            is_ignored: properties["ignored"] == true,
        });
    }
    tests.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(tests)
}

/// Memory taken by an image, bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Memory {
    /// Flash: code, constants, and initial values of variables.
    pub flash: u64,
    /// RAM: variables, without the stack.
    pub static_ram: u64,
}

/// Memory taken by the image `elf`.
///
/// # Errors
/// The file is unreadable, or has no code.
pub fn memory(elf: &Path) -> Result<Memory> {
    let bytes = read(elf)?;
    let file = parse(elf, &bytes)?;
    let size = |name: &str| file.section_by_name(name).map_or(0, |section| section.size());
    let code = size(".text");
    ensure!(code > 0, "{} has no .text section: not a firmware image", elf.display());
    Ok(Memory {
        flash: size(".vector_table") + code + size(".rodata") + size(".data"),
        static_ram: size(".data") + size(".bss") + size(".uninit"),
    })
}

/// Bytes of the image `elf`.
pub(crate) fn read(elf: &Path) -> Result<Vec<u8>> {
    std::fs::read(elf).with_context(|| format!("cannot read {}", elf.display()))
}

/// Symbols and sections in the bytes of the image `elf`.
fn parse<'a>(elf: &Path, bytes: &'a [u8]) -> Result<object::File<'a>> {
    object::File::parse(bytes).with_context(|| format!("{} is not an ELF file", elf.display()))
}

/// True if the symbol is a log text: defmt stores them in symbols, as JSON.
fn is_log_text(symbol: &str) -> bool {
    symbol.starts_with('{')
}

/// True if the symbol must not be in flight code.
pub fn is_unwanted(symbol: &str) -> bool {
    UNWANTED.iter().any(|part| symbol.contains(part))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbols_of_panics_are_unwanted() {
        assert!(is_unwanted("_RNvNtCs1_4core9panicking18panic_bounds_check"));
        assert!(is_unwanted("__aeabi_dmul"));
        assert!(!is_unwanted("__aeabi_memcpy"));
        assert!(!is_unwanted("main"));
    }
}
