//! decor's adapter for POV-Ray.
