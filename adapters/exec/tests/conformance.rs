//! What every adapter passes, with the example in Python behind the protocol.

use decor_exec::{Exec, protocol};

const EXAMPLE: &str = concat!(
    "python3 '",
    env!("CARGO_MANIFEST_DIR"),
    "/example/raycast.py'"
);

decor_api::conformance!(|| Exec::find(EXAMPLE), program: |path| {
    Ok(Exec::at(path, "stand-in 1", protocol::Abilities::default()))
});
