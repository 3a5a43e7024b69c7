//! Boards of the images, each with its compiler target and its machine in QEMU.

use anyhow::{Context, Result};

/// A board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Board {
    /// Cargo feature of fsw-target.
    pub feature: &'static str,
    /// Core.
    pub core: &'static str,
    /// Target of the compiler.
    pub target: &'static str,
    /// Machine of QEMU.
    pub machine: &'static str,
}

/// The flight board.
pub const STM32F405: Board = Board {
    feature: "stm32f405",
    core: "Cortex-M4F",
    target: crate::toolchain::TARGET,
    machine: crate::qemu::MACHINE,
};

/// Arm MPS2 with the FPGA image AN500. Instructions of the Cortex-M4F, which are a part of those of this core: both share
/// all build products but fsw-target.
pub const MPS2_AN500: Board = Board {
    feature: "mps2-an500",
    core: "Cortex-M7",
    target: crate::toolchain::TARGET,
    machine: "mps2-an500",
};

/// Arm MPS2 with the FPGA image AN505.
pub const MPS2_AN505: Board = Board {
    feature: "mps2-an505",
    core: "Cortex-M33",
    target: "thumbv8m.main-none-eabihf",
    machine: "mps2-an505",
};

/// All boards.
pub const BOARDS: [Board; 3] = [STM32F405, MPS2_AN500, MPS2_AN505];

impl Board {
    /// The board with this feature.
    ///
    /// # Errors
    /// No such board. The message lists all.
    pub fn of_name(name: &str) -> Result<Self> {
        BOARDS.into_iter().find(|board| board.feature == name).with_context(|| {
            let names = BOARDS.map(|board| board.feature);
            format!("no board {name}; boards: {}", names.join(", "))
        })
    }

    /// Features of fsw-target for an image with all estimators.
    pub fn features(&self) -> String {
        format!("{},window,joint-ekf,ekf-sgf-rls", self.feature)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boards_are_found_by_their_feature() {
        for board in BOARDS {
            assert_eq!(Board::of_name(board.feature).unwrap(), board);
        }
        let error = Board::of_name("nucleo").unwrap_err().to_string();
        assert_eq!(error, "no board nucleo; boards: stm32f405, mps2-an500, mps2-an505");
    }
}
