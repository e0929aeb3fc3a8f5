//! Nothing but tests: they are in `tests/`, one file a subject.
