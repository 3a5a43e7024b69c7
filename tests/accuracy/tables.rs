//! The list of campaigns. One entry per row of the accuracy tables.

use super::campaign::Row;

/// One table of a page.
#[derive(Clone, Copy, Debug)]
pub struct Table {
    /// Name of its markers.
    pub name: &'static str,
    /// Page, from the root of the repository.
    pub page: &'static str,
    /// Its figures.
    pub columns: Columns,
    /// Its campaigns.
    pub rows: &'static [Row],
}

/// The figures of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Columns {
    /// Error over bound, NEES, failures.
    Summary,
    /// The same with bias, changes and residuals.
    Full,
    /// Flights with stated errors of the hardware: error over the bound that solves for them, NEES, verdicts.
    Hardware,
    /// Verdicts alone: for estimators most of whose runs fail.
    Verdicts,
    /// Runs whose residuals are called not white under a torque of 5, 6 and 8 sigma about x, y, z.
    WhiteResiduals,
}

impl Columns {
    /// The two lines above the rows.
    pub fn head(self) -> String {
        let names: &[&str] = match self {
            Self::Summary => &["campaign", "command", "RMS / bound", "NEES", "failed"],
            Self::Full => &[
                "command",
                "RMS / bound",
                "bias / bound",
                "NEES",
                "diverged",
                "not converged",
                "changes",
                "not white",
            ],
            Self::Hardware => &[
                "command",
                "RMS / joint bound",
                "NEES",
                "silent lies",
                "diverged",
                "not converged",
                "not white",
            ],
            Self::Verdicts => &["command", "converged", "not converged", "diverged"],
            Self::WhiteResiduals => &["scenario, axis, runs", "5 sigma", "6 sigma", "8 sigma"],
        };
        format!("| {} |\n|{}", names.join(" | "), "---|".repeat(names.len()))
    }
}

impl Table {
    /// The opening cells of a row, known without a campaign.
    pub fn row_start(&self, row: &Row) -> String {
        match self.columns {
            Columns::Summary => format!("| {} | `{}` |", row.title, row.command()),
            Columns::Full | Columns::Hardware | Columns::Verdicts => format!("| `{}` |", row.command()),
            Columns::WhiteResiduals => {
                format!("| `{}`, {}, {} |", row.scenario, row.title, row.runs)
            }
        }
    }

    /// A row with its figures.
    pub fn row(&self, row: &Row, cells: &[String]) -> String {
        format!("{} {} |", self.row_start(row), cells.join(" | "))
    }
}

/// Every table.
pub const TABLES: &[Table] = &[
    Table { name: "summary", page: "README.md", columns: Columns::Summary, rows: SUMMARY },
    Table { name: "window", page: PAGE, columns: Columns::Full, rows: WINDOW },
    Table { name: "hardware", page: PAGE, columns: Columns::Hardware, rows: HARDWARE },
    Table { name: "white", page: PAGE, columns: Columns::WhiteResiduals, rows: WHITE },
    Table { name: "spin-up", page: PAGE, columns: Columns::Full, rows: SPIN_UP },
    Table { name: "start", page: PAGE, columns: Columns::Verdicts, rows: START },
];

const PAGE: &str = "fsw-core/docs/accuracy.md";

const SPIN_UP_BY_WINDOW: Row = Row::window("stsat3-spin-up", 2000).titled("external torque");
const SPIN_UP_BY_JOINT_EKF: Row =
    Row::window("stsat3-spin-up", 1000).by("joint-ekf").titled("the same, `joint-ekf`");
const CUBESAT: Row = Row::window("cubesat-pyramid", 10_000).titled("four wheels");
const DISTURBED: Row =
    Row::window("cubesat-pyramid-disturbed", 10_000).titled("torque and gyro bias unknown");
const RANDOM: Row = Row::window("random-spacecraft", 1000).titled("random spacecraft");
const RANDOM_HARDWARE: Row = Row::window("random-spacecraft-data-sheet", 2000)
    .titled("the same, gyro, wheels and torque as good as their data sheets");

const SUMMARY: &[Row] =
    &[SPIN_UP_BY_WINDOW, SPIN_UP_BY_JOINT_EKF, CUBESAT, DISTURBED, RANDOM, RANDOM_HARDWARE];

const HARDWARE: &[Row] = &[
    Row::window("cubesat-pyramid-data-sheet", 1000),
    Row::window("microsat-slew-data-sheet", 1000),
    Row::window("stsat3-spin-up-data-sheet", 1000),
    RANDOM_HARDWARE,
    Row::window("cubesat-pyramid-data-sheet", 1000).by("joint-ekf"),
];

const WINDOW: &[Row] = &[
    SPIN_UP_BY_WINDOW,
    Row::window("stsat3-spin-up", 1000).in_double(),
    Row::window("stsat3-spin-up-wrong-prior", 1000),
    Row::window("stsat3-spin-up-overconfident-prior", 1000),
    Row::window("microsat-slew", 2000),
    Row::window("microsat-slew", 1000).in_double(),
    CUBESAT,
    Row::window("cubesat-pyramid", 2000).in_double(),
    DISTURBED,
    RANDOM,
    Row::window("deployment", 2000),
    Row::window("break-off", 2000),
    Row::window("no-change", 2000),
    Row::window("fuel-burn", 300),
    Row::window("elhariry-2026-sine-iso-0.2", 200),
];

const WHITE: &[Row] = &[
    Row::window("stsat3-spin-up", 1000).titled("x"),
    Row::window("cubesat-pyramid", 1000).titled("x"),
    Row::window("cubesat-pyramid", 1000).titled("y"),
    Row::window("cubesat-pyramid", 1000).titled("z"),
];

const SPIN_UP: &[Row] = &[
    SPIN_UP_BY_JOINT_EKF,
    Row::window("stsat3-spin-up", 1000).by("joint-ekf").in_double(),
    Row::window("stsat3-spin-up", 1000).by("joint-ekf-unaligned").in_double(),
    Row::window("stsat3-spin-up", 1000).by("joint-ekf-published").in_double(),
    Row::window("stsat3-spin-up", 1000).by("joint-ekf-published"),
];

const START: &[Row] = &[
    Row::window("bellar-2019-campaign", 2000).by("joint-ekf-published"),
    Row::window("bellar-2019-campaign", 2000).by("joint-ekf-published").in_double(),
    Row::window("bellar-2019-campaign", 2000).by("joint-ekf-unaligned"),
    Row::window("bellar-2019-campaign", 2000).by("joint-ekf-unaligned").in_double(),
    Row::window("bellar-2019-campaign", 2000).by("joint-ekf"),
    Row::window("bellar-2019-campaign", 2000).by("joint-ekf").in_double(),
    Row::window("bellar-2019-campaign", 2000),
];
