//! Choice of the board: exactly one, and compiled for the target of its core.

use std::path::Path;

/// A board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Board {
    /// Cargo feature.
    pub feature: &'static str,
    /// Target of the compiler.
    pub target: &'static str,
    /// Folder in `src/board`, with its `memory.x`.
    pub folder: &'static str,
    /// The register crate brings the linker script of the interrupts, `device.x`.
    pub has_device_script: bool,
}

/// All boards.
pub const BOARDS: [Board; 3] = [
    Board {
        feature: "stm32f405",
        target: "thumbv7em-none-eabihf",
        folder: "stm32f405",
        has_device_script: true,
    },
    Board {
        feature: "mps2-an500",
        target: "thumbv7em-none-eabihf",
        folder: "mps2/an500",
        has_device_script: false,
    },
    Board {
        feature: "mps2-an505",
        target: "thumbv8m.main-none-eabihf",
        folder: "mps2/an505",
        has_device_script: false,
    },
];

/// The only board of which `is_selected`, for this target.
///
/// # Errors
/// No board or more than one; the target of another core.
pub fn choose(is_selected: impl Fn(&str) -> bool, target: &str) -> Result<Board, String> {
    let selected: Vec<_> = BOARDS.into_iter().filter(|board| is_selected(board.feature)).collect();
    let [board] = selected[..] else {
        let list = |boards: &[Board]| {
            boards.iter().map(|board| board.feature).collect::<Vec<_>>().join(", ")
        };
        let found = if selected.is_empty() { "none".into() } else { list(&selected) };
        return Err(format!(
            "fsw-target: cargo features select {found} where one board is needed; build with `--no-default-features \
             --features BOARD,window,joint-ekf,ekf-sgf-rls`, BOARD one of {}",
            list(&BOARDS)
        ));
    };
    if target != board.target {
        let Board { feature, target: expected, .. } = board;
        return Err(format!(
            "fsw-target: board {feature} cannot be built for {target}: build with `--target {expected}`"
        ));
    }
    Ok(board)
}

/// Copies the memory file of the board to `out`, where the `memory.x` of the workspace includes it, and adds the linker
/// script of the interrupts where no register crate does.
pub fn write_scripts(board: &Board, package: &Path, out: &Path) -> std::io::Result<()> {
    let memory = package.join("src/board").join(board.folder).join("memory.x");
    println!("cargo:rerun-if-changed={}", memory.display());
    std::fs::copy(memory, out.join("board.x"))?;
    if !board.has_device_script {
        std::fs::write(out.join("device.x"), "/* Interrupts have no handlers by name. */\n")?;
    }
    println!("cargo:rustc-link-search={}", out.display());
    Ok(())
}
