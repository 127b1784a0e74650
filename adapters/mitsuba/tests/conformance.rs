//! What every adapter passes.

use decor_mitsuba::Mitsuba;

decor_api::conformance!(Mitsuba::find, program: |path| {
    Ok(Mitsuba::new(path.to_owned(), "3.9.1"))
});
