//! Static libraries, C compilers and QEMU.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use target_tools::toolchain::Toolchain;

/// Compiler for the Cortex-M: Debian package `gcc-arm-none-eabi`.
const TARGET_COMPILER: &str = "arm-none-eabi-gcc";
/// Processor of the target: as rustc has it for thumbv7em-none-eabihf.
const CORTEX_M4F: [&str; 4] =
    ["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"];
/// Warnings that stop a build.
const STRICT: [&str; 5] = ["-Wall", "-Wextra", "-Werror", "-pedantic", "-O2"];

/// Folder of the package.
fn package() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A static library.
pub struct Library(PathBuf);

impl Library {
    /// For this host, with the standard library.
    pub fn of_host() -> Self {
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
        cargo.args(["rustc", "--features", "std"]);
        Self::build(&mut cargo)
    }

    /// For the Cortex-M4F.
    pub fn of_target() -> Self {
        let mut cargo = Toolchain::find().unwrap().cargo("rustc").unwrap();
        cargo.args(["--features", "panic-handler", "--profile", "firmware"]);
        Self::build(&mut cargo)
    }

    fn build(cargo: &mut Command) -> Self {
        cargo.args(["--package", "fsw-core-c", "--lib", "--crate-type", "staticlib"]);
        cargo.args(["--message-format", "json-render-diagnostics"]).current_dir(package());
        let output = cargo.stderr(Stdio::inherit()).output().unwrap();
        assert!(output.status.success(), "the static library was not built");
        let messages = String::from_utf8(output.stdout).unwrap();
        let mut quoted = messages.split('"');
        let path = quoted.rfind(|text| text.ends_with("fsw_core_c.a")).unwrap();
        Self(path.into())
    }
}

/// Program from C sources; further arguments stand among them.
pub fn compile_on_host(library: &Library, sources: &[&str]) -> PathBuf {
    let mut compiler = Command::new("gcc");
    compiler.arg("-std=c11");
    compile(&mut compiler, library, sources, &["-lm", "-lpthread", "-ldl"])
}

/// Program from C++ sources.
pub fn compile_cpp_on_host(library: &Library, sources: &[&str]) -> PathBuf {
    let mut compiler = Command::new("g++");
    compiler.arg("-std=c++14");
    compile(&mut compiler, library, sources, &["-lm", "-lpthread", "-ldl"])
}

/// Image for the STM32F405 in QEMU.
pub fn compile_on_target(library: &Library, sources: &[&str]) -> PathBuf {
    let mut compiler = Command::new(TARGET_COMPILER);
    compiler.args(["-std=c11", "-ffreestanding", "-nostdlib"]).args(CORTEX_M4F);
    compiler.args(["-ffunction-sections", "-fdata-sections", "-Wl,--gc-sections"]);
    compiler.arg("-Wl,-z,noexecstack");
    compile(&mut compiler, library, sources, &["-Texamples/target/stm32f405.ld", "-lgcc"])
}

fn compile(
    compiler: &mut Command,
    library: &Library,
    sources: &[&str],
    options: &[&str],
) -> PathBuf {
    let folder = tempfile::tempdir().unwrap().keep();
    let program = folder.join("program");
    compiler.args(STRICT).args(sources).arg(&library.0).args(options).arg("-o").arg(&program);
    let name = compiler.get_program().to_owned();
    let output = compiler.current_dir(package()).output().unwrap_or_else(|error| {
        panic!("{name:?} does not start ({error}): Debian has it as gcc, g++, gcc-arm-none-eabi")
    });
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    program
}

/// Runs a program to its end, and removes it.
pub fn run(program: &Path) -> String {
    let printed = output(&mut Command::new(program));
    std::fs::remove_dir_all(program.parent().unwrap()).unwrap();
    printed
}

/// Runs an image to its end, 16 ns of virtual time per instruction.
pub fn run_in_qemu(program: &Path) -> String {
    let mut qemu = Command::new("timeout");
    qemu.args(["300", "qemu-system-arm", "-machine", target_tools::qemu::MACHINE]);
    qemu.args(["-display", "none", "-monitor", "none", "-serial", "none", "-icount", "shift=4"]);
    qemu.args(["-semihosting-config", "enable=on,target=native,chardev=out"]);
    qemu.args(["-chardev", "stdio,id=out", "-kernel"]).arg(program).stdin(Stdio::null());
    output(&mut qemu)
}

fn output(command: &mut Command) -> String {
    let output = command.output().unwrap();
    let printed = String::from_utf8(output.stdout).unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}\n{printed}\n{errors}", output.status);
    printed
}

/// No panic of the Rust code is linked into an image.
pub fn assert_no_panic(program: &Path) {
    let symbols = output(Command::new("arm-none-eabi-nm").arg("-C").arg(program));
    assert!(symbols.contains("fsw_window_step"), "symbols of the image");
    let panics: Vec<_> = symbols.lines().filter(|line| line.contains("panic")).collect();
    assert!(panics.is_empty(), "{panics:#?}");
}
