//! Choice of the board by the build script.

#![allow(clippy::unwrap_used, reason = "a test that cannot continue fails")]

#[allow(dead_code, reason = "the scripts are for the build")]
#[path = "../build/board.rs"]
mod board;

use board::{BOARDS, choose};

const M4: &str = "thumbv7em-none-eabihf";

#[test]
fn each_board_alone_is_chosen_for_its_target() {
    for board in BOARDS {
        assert_eq!(choose(|feature| feature == board.feature, board.target), Ok(board));
    }
}

#[test]
fn none_or_several_boards_are_an_error_that_names_them() {
    let none = choose(|_| false, M4).unwrap_err();
    assert!(
        none.contains("select none") && none.contains("one of stm32f405, mps2-an500, mps2-an505")
    );
    let two = choose(|feature| feature != "mps2-an505", M4).unwrap_err();
    assert!(two.contains("select stm32f405, mps2-an500 where one board is needed"), "{two}");
}

#[test]
fn target_of_another_core_is_an_error() {
    let error = choose(|feature| feature == "mps2-an505", M4).unwrap_err();
    assert!(error.contains("build with `--target thumbv8m.main-none-eabihf`"), "{error}");
}
