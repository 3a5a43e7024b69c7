//! Work that Ctrl-C ends.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// Time between two checks for signals.
const POLL: Duration = Duration::from_millis(50);

/// Does `work` on a thread without the interpreter, which handles signals meanwhile. A signal that raises sets the flag
/// of `work`; its exception is raised once the work has ended.
pub fn interruptible<T: Send>(
    py: Python<'_>,
    work: impl FnOnce(&AtomicBool) -> T + Send,
) -> PyResult<T> {
    let (stop, is_over) = (AtomicBool::new(false), AtomicBool::new(false));
    let (stop, is_over) = (&stop, &is_over);
    let caller = thread::current();
    thread::scope(|scope| {
        let worker = scope.spawn(move || {
            let result = work(stop);
            is_over.store(true, Ordering::Release);
            caller.unpark();
            result
        });
        let mut raised = None;
        while !is_over.load(Ordering::Acquire) && !worker.is_finished() {
            py.detach(|| thread::park_timeout(POLL));
            if let Err(error) = py.check_signals() {
                stop.store(true, Ordering::Relaxed);
                raised.get_or_insert(error);
            }
        }
        let result = py.detach(|| worker.join());
        match (raised, result) {
            (Some(error), _) => Err(error),
            (None, Ok(result)) => Ok(result),
            (None, Err(_)) => Err(PyRuntimeError::new_err("the work ended without a result")),
        }
    })
}
