//! What every adapter passes. The way that reads 16-bit pictures is not among
//! them: its depth is as coarse as it says, coarser than conformance allows.

use decor_povray::PovRay;

decor_api::conformance!(PovRay::find, program: |path| {
    Ok(PovRay::new(path.to_owned(), "3.7.0.10"))
});
