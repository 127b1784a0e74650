//! POV-Ray is there and works: everything else in this crate's tests needs it.

use decor_api::{Adapter, RunContext};
use decor_povray::{LayerSource, PovRay};

#[test]
fn povray_is_healthy_in_both_ways_of_reading() {
    for source in [LayerSource::StateFile, LayerSource::Pictures] {
        let povray = PovRay::find()
            .expect("POV-Ray is installed")
            .with_source(source);
        let folder = tempfile::tempdir().unwrap();
        let health = povray.health(&RunContext::new(folder.path()));
        assert!(health.is_good(), "{source:?}: {:#?}", health.checks);
        let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
        assert!(left.is_empty(), "files are left behind: {left:?}");
    }
}
