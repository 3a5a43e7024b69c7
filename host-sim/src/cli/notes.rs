//! Notes to the user: printed as they arise, and kept for the report.

/// Notes, one sentence each.
#[derive(Debug, Default)]
pub(super) struct Notes(Vec<String>);

impl Notes {
    /// Prints a note to stderr and keeps it.
    pub(super) fn add(&mut self, note: impl Into<String>) {
        let note = note.into();
        eprintln!("note: {note}");
        self.0.push(note);
    }

    /// The notes in the order of their printing.
    pub(super) fn into_list(self) -> Vec<String> {
        self.0
    }
}
