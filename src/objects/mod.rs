//! Object descriptions: from a path to a prototype.
