//! The tests that every adapter passes. Behind the feature `conformance`, which
//! only the tests of adapters ask for: it costs users nothing.
//!
//! An adapter's `tests/conformance.rs` is one call of [`conformance!`](crate::conformance!):
//!
//! ```ignore
//! decor_api::conformance!(
//!     || MyRenderer::find(),
//!     program: |path| Ok(MyRenderer::new(path.to_owned(), "1.0")),
//! );
//! ```
//!
//! Each function of the modules below is then one `#[test]`. Most draw a small
//! picture and hold it against an oracle that needs no renderer: spheres, boxes
//! and planes in closed form ([`oracle`]). They are told nothing of the renderer
//! but its [`Abilities`](crate::Abilities), and ask for what these promise: an
//! ability that is claimed is tried; where one is missing, the adapter refuses
//! with [`AdapterError::Unsupported`], or draws as the documentation of that
//! ability says.
//!
//! A renderer that is not installed makes its tests fail, not pass by silence.

pub mod abilities;
pub mod depth;
pub mod film;
pub mod oracle;
pub mod pictures;
pub mod processes;
pub mod refusals;
pub mod regions;
pub mod stage;
pub mod text;

use std::path::Path;

use crate::adapter::{Adapter, AdapterError};

type Found = Result<Box<dyn Adapter>, AdapterError>;
type Around = Box<dyn Fn(&Path) -> Found>;

/// The adapter that is tested.
pub struct Subject {
    find: Box<dyn Fn() -> Found>,
    with_program: Option<Around>,
}

impl Subject {
    /// The adapter that `find` finds.
    pub fn new<A: Adapter + 'static>(find: impl Fn() -> Result<A, AdapterError> + 'static) -> Self {
        Self {
            find: Box::new(move || Ok(Box::new(find()?))),
            with_program: None,
        }
    }

    /// The same adapter around another program: tests put one there that hangs,
    /// or dies.
    #[must_use]
    pub fn with_program<A: Adapter + 'static>(
        mut self,
        around: impl Fn(&Path) -> Result<A, AdapterError> + 'static,
    ) -> Self {
        self.with_program = Some(Box::new(move |path| Ok(Box::new(around(path)?))));
        self
    }

    /// The adapter.
    ///
    /// # Panics
    /// Where its renderer is missing: that fails the test.
    pub fn adapter(&self) -> Box<dyn Adapter> {
        match (self.find)() {
            Ok(adapter) => adapter,
            Err(error) => panic!("the renderer is not there to be tested: {error}"),
        }
    }

    /// The adapter around the program at `path`.
    ///
    /// # Panics
    /// Where it was not said how, or that fails.
    pub fn around(&self, path: &Path) -> Box<dyn Adapter> {
        let around = self
            .with_program
            .as_ref()
            .expect("the way to another program");
        match around(path) {
            Ok(adapter) => adapter,
            Err(error) => panic!("an adapter around {}: {error}", path.display()),
        }
    }
}

/// Gives an adapter its tests, one `#[test]` each.
///
/// The first argument finds the adapter; it gives a `Result<impl Adapter,
/// AdapterError>`. The second says how it draws: `in_process`, or `program:`
/// and a closure that makes the adapter around another program, without calling
/// it. Two calls in one file stand in a module each.
#[macro_export]
macro_rules! conformance {
    ($find:expr, in_process $(,)?) => {
        fn subject() -> $crate::conformance::Subject {
            $crate::conformance::Subject::new($find)
        }
        $crate::conformance!(@everywhere);
    };
    ($find:expr, program: $around:expr $(,)?) => {
        fn subject() -> $crate::conformance::Subject {
            fn typed<A, F>(around: F) -> F
            where
                F: Fn(&std::path::Path) -> Result<A, $crate::AdapterError>,
            {
                around
            }
            $crate::conformance::Subject::new($find).with_program(typed($around))
        }
        $crate::conformance!(@everywhere);
        $crate::conformance!(@tests processes:
            a_program_that_fails_is_quoted,
            a_program_that_is_killed_is_a_failure,
            a_program_that_hangs_is_stopped_with_its_children,
            a_program_that_hangs_can_be_cancelled,
            a_program_that_writes_nothing_is_found_out,
            a_program_that_is_not_there_is_an_error,
        );
    };
    (@everywhere) => {
        $crate::conformance!(@tests text:
            the_text_is_deterministic,
            the_text_says_what_changed,
            files_have_plain_names_of_their_own,
            names_cannot_clash,
        );
        $crate::conformance!(@tests depth:
            the_depth_of_spheres,
            the_depth_of_boxes,
            the_depth_of_planes,
            the_depth_of_instances,
            the_depth_of_what_is_near_and_far,
            the_depth_far_from_the_origin,
            the_depth_from_inside,
        );
        $crate::conformance!(@tests regions:
            what_is_empty_is_empty,
            an_empty_window_is_a_layer,
            windows_are_where_they_say,
            crops_on_the_grid_are_identical,
            blocks_are_identical,
            a_batch_comes_back_in_order,
        );
        $crate::conformance!(@tests pictures:
            colours_and_outlines_are_right,
            objects_alone_leave_the_rest_empty,
            threads_change_nothing,
            calls_side_by_side_do_not_disturb_each_other,
            the_baseline_is_what_is_merged,
            the_encoding_rises_from_end_to_end,
        );
        $crate::conformance!(@tests abilities:
            abilities_are_plausible,
            the_renderer_is_healthy,
            csg_is_drawn_or_refused,
            shadows_are_cast_as_declared,
            hidden_casters_are_hidden_or_refused,
            mirrors_are_drawn_as_declared,
            coverage_is_stated_as_declared,
            depth_comes_with_colour_as_declared,
            light_arrives_or_is_refused,
        );
        $crate::conformance!(@tests refusals:
            fragments_of_another_language_are_refused,
            surroundings_of_no_known_language_are_refused,
            a_cancelled_run_stops,
            a_late_run_is_stopped,
        );
        $crate::conformance!(@tests film:
            names_may_be_odd,
            folders_may_be_odd,
            ten_thousand_instances_are_drawn,
            nothing_is_left_behind,
        );
    };
    (@tests $module:ident: $($name:ident,)*) => {
        $(
            #[test]
            fn $name() {
                $crate::conformance::$module::$name(&subject());
            }
        )*
    };
}
