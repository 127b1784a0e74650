//! Bundled films made small, with an observer who moves slowly: there décors are
//! kept for a while, and are wrong by a little.
#![allow(dead_code)]

use std::path::{Path, PathBuf};

use crate::common::fixture;

/// The lines of a bundled film with some of them replaced, beside its objects.
fn changed(name: &str, folder: &Path, lines: &[(&str, &str)]) -> PathBuf {
    let source = fixture(name);
    let source_folder = source.parent().expect("it is in a folder");
    for file in std::fs::read_dir(source_folder).expect("the fixture is there") {
        let file = file.expect("a file");
        std::fs::copy(file.path(), folder.join(file.file_name())).expect("it can be copied");
    }
    let text = std::fs::read_to_string(&source).expect("the film can be read");
    let mut found = 0;
    let mut film = String::new();
    for line in text.lines() {
        let word = line.split_whitespace().next().unwrap_or_default();
        match lines.iter().find(|(keyword, _)| *keyword == word) {
            Some((_, new)) => {
                film += new;
                found += 1;
            }
            None => film += line,
        }
        film.push('\n');
    }
    assert_eq!(found, lines.len(), "{name} has other lines now");
    let path = folder.join("moving.anim");
    std::fs::write(&path, film).expect("the film can be written");
    path
}

/// Ladybirds all around, and an observer who drifts by a twentieth a frame.
pub fn ladybirds(folder: &Path) -> PathBuf {
    let lines = [
        ("*size", "*size 160 120"),
        ("*images", "*images 12"),
        ("*eye", "*eye 0 0 -40  0 0 0.05"),
        ("*aim", "*aim 0 0 60  0 0 0.05"),
    ];
    changed("ladybirds/ladybirds.anim", folder, &lines)
}

/// Toys on a floor, seen by somebody who walks past.
pub fn contact(folder: &Path) -> PathBuf {
    let lines = [
        ("*size", "*size 160 120"),
        ("*images", "*images 20"),
        ("*eye", "*eye 0 5.4 -13.2  0.006 0 0"),
        ("*aim", "*aim 0 1.55 0.3  0.006 0 0"),
    ];
    changed("contact/contact.anim", folder, &lines)
}

/// An airplane comes in, and the observer steps aside. For POV-Ray.
pub fn plane(folder: &Path) -> PathBuf {
    let lines = [
        ("*size", "*size 160 120"),
        ("*images", "*images 16"),
        ("*sky", ""),
        ("*eye", "*eye 0 14 0  0.04 0 0"),
        ("*aim", "*aim 0 24 150  0.04 0 0"),
    ];
    changed("plane/plane.anim", folder, &lines)
}
