use std::sync::{Arc, Mutex, PoisonError};

/// The last value derived from an input that usually stays the same.
#[derive(Debug)]
pub(crate) struct Derived<T>(Mutex<Option<Made<T>>>);

#[derive(Debug)]
struct Made<T> {
    /// Kept alive, so that no other input gets its address.
    from: Arc<T>,
    to: Arc<T>,
}

impl<T> Derived<T> {
    /// Returns `make(from)`, which is computed again only when `from` is another allocation than last time.
    pub(crate) fn of(&self, from: &Arc<T>, make: impl FnOnce(&T) -> T) -> Arc<T> {
        let mut last = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match &*last {
            Some(last) if Arc::ptr_eq(&last.from, from) => Arc::clone(&last.to),
            _ => {
                let to = Arc::new(make(from));
                *last = Some(Made { from: Arc::clone(from), to: Arc::clone(&to) });
                to
            }
        }
    }
}

impl<T> Default for Derived<T> {
    fn default() -> Self {
        Self(Mutex::new(None))
    }
}
