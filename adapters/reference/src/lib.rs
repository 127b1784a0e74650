//! decor's in-process ray caster.
