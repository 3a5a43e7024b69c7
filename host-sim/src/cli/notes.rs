//! Notes to the user: printed as they arise, and kept for the report.

/// Notes, one sentence each.
#[derive(Debug, Default)]
pub(super) struct Notes {
    list: Vec<String>,
    is_quiet: bool,
}

impl Notes {
    /// Notes that are only kept.
    pub(super) fn quiet() -> Self {
        Self { is_quiet: true, ..Self::default() }
    }

    /// Prints a note to stderr and keeps it.
    pub(super) fn add(&mut self, note: impl Into<String>) {
        let note = note.into();
        if !self.is_quiet {
            eprintln!("note: {note}");
        }
        self.list.push(note);
    }

    /// The notes in the order of their printing.
    pub(super) fn into_list(self) -> Vec<String> {
        self.list
    }
}
