//! The film model, its formats, its validation.
