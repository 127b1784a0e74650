//! What every adapter passes.

use decor_reference::Reference;

decor_api::conformance!(|| Ok(Reference::new()), in_process);
