//! What is inside an ELF image: the functions and data that the linker kept.

use anyhow::{Context, Result, ensure};
use object::{Object, ObjectSection, ObjectSymbol};
use std::path::Path;

/// Parts of names that flight code should not contain: panics (slice index, unwrap, division by
/// zero, overflow), heap allocation, and double precision, which a Cortex-M4F emulates.
const UNWANTED: [&str; 7] =
    ["panicking", "panic_", "_failed", "rust_begin_unwind", "__rust_alloc", "__rg_", "__aeabi_d"];

/// The (mangled) names of all symbols of the image `elf`.
pub fn symbols(elf: &Path) -> Result<Vec<String>> {
    let bytes = std::fs::read(elf).with_context(|| format!("could not read {}", elf.display()))?;
    let file = object::File::parse(&*bytes).with_context(|| elf.display().to_string())?;
    let names = file.symbols().filter_map(|symbol| symbol.name().ok().map(String::from));
    // defmt keeps the text of the log in symbols, as JSON: text, not code.
    Ok(names.filter(|name| !name.starts_with('{')).collect())
}

/// Where the functions of the image `elf` begin whose (mangled) names contain one of these.
pub fn functions(elf: &Path, names: &[&str]) -> Result<Vec<u32>> {
    let bytes = std::fs::read(elf).with_context(|| format!("could not read {}", elf.display()))?;
    let file = object::File::parse(&*bytes).with_context(|| elf.display().to_string())?;
    let is_wanted = |name: &str| !name.starts_with('{') && names.iter().any(|n| name.contains(n));
    let wanted = file.symbols().filter(|symbol| symbol.name().is_ok_and(is_wanted));
    // The lowest bit says that it is Thumb code.
    Ok(wanted.map(|symbol| symbol.address() as u32 & !1).collect())
}

/// What an image takes of the chip's memory, bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Memory {
    /// Flash: code, constants, and the first values of variables.
    pub flash: u64,
    /// RAM of variables, without the stack.
    pub static_ram: u64,
}

/// What the image `elf` takes.
///
/// # Errors
/// It can't be read, or has no code.
pub fn memory(elf: &Path) -> Result<Memory> {
    let bytes = std::fs::read(elf).with_context(|| format!("could not read {}", elf.display()))?;
    let file = object::File::parse(&*bytes).with_context(|| elf.display().to_string())?;
    let size = |name: &str| file.section_by_name(name).map_or(0, |section| section.size());
    let code = size(".text");
    ensure!(code > 0, "{} has no code", elf.display());
    Ok(Memory {
        flash: size(".vector_table") + code + size(".rodata") + size(".data"),
        static_ram: size(".data") + size(".bss") + size(".uninit"),
    })
}

/// Whether flight code should not contain this symbol.
pub fn is_unwanted(symbol: &str) -> bool {
    UNWANTED.iter().any(|part| symbol.contains(part))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn knows_the_symbols_of_a_panic() {
        assert!(is_unwanted("_RNvNtCs1_4core9panicking18panic_bounds_check"));
        assert!(is_unwanted("__aeabi_dmul"));
        assert!(!is_unwanted("__aeabi_memcpy"));
        assert!(!is_unwanted("main"));
    }
}
