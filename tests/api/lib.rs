//! Only its tests do something: they need much to be built that nobody else needs.
