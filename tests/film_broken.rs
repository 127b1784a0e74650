//! What bad films get: an error with its place, and nothing else.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use decor::film::{self, FilmErrors, FilmStream, Problem};
use miette::{GraphicalReportHandler, GraphicalTheme};

const FOLDER: &str = "fixtures/broken";

/// Tests run in the package's folder, so these paths are relative to it and the
/// messages are the same on every machine.
fn broken_films() -> Vec<PathBuf> {
    let mut films: Vec<PathBuf> = std::fs::read_dir(FOLDER)
        .unwrap()
        .map(|entry| Path::new(FOLDER).join(entry.unwrap().file_name()))
        .filter(|path| film::Form::of(path).is_some())
        .collect();
    films.sort();
    films
}

fn rendered(errors: &FilmErrors) -> String {
    let mut text = String::new();
    GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor())
        .with_width(100)
        .render_report(&mut text, errors)
        .unwrap();
    let lines: Vec<&str> = text.lines().map(str::trim_end).collect();
    lines.join("\n")
}

fn tree(folder: &Path, into: &mut BTreeMap<PathBuf, Vec<u8>>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            // The snapshots are the test's own.
            if path != Path::new(FOLDER).join("expected") {
                tree(&path, into);
            }
        } else {
            let bytes = std::fs::read(&path).unwrap();
            into.insert(path, bytes);
        }
    }
}

#[test]
fn every_broken_film_gets_its_message_and_touches_nothing() {
    let films = broken_films();
    assert!(films.len() >= 45, "{} films", films.len());
    let mut before = BTreeMap::new();
    tree(Path::new(FOLDER), &mut before);
    for path in &films {
        let errors = film::read(path, false).expect_err(&path.display().to_string());
        assert!(!errors.errors().is_empty());
        for error in errors.errors() {
            assert!(error.line().is_some_and(|line| line >= 1), "{error}");
            assert!(error.column().is_some_and(|column| column >= 1), "{error}");
        }
        let mut settings = insta::Settings::clone_current();
        settings.set_snapshot_path("../fixtures/broken/expected");
        settings.set_prepend_module_to_snapshot(false);
        settings.set_omit_expression(true);
        let name = path.file_name().unwrap().to_str().unwrap();
        settings.bind(|| insta::assert_snapshot!(name, rendered(&errors)));
    }
    let mut after = BTreeMap::new();
    tree(Path::new(FOLDER), &mut after);
    assert_eq!(before, after);
}

#[test]
fn no_message_of_a_fixture_is_left_over() {
    let films = broken_films();
    let names: Vec<&str> = films
        .iter()
        .filter_map(|path| path.file_name()?.to_str())
        .collect();
    for entry in std::fs::read_dir(Path::new(FOLDER).join("expected")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let film = name.trim_end_matches(".new").trim_end_matches(".snap");
        assert!(names.contains(&film), "{name} belongs to no film");
    }
}

#[test]
fn a_stream_refuses_what_a_file_refuses() {
    // A file may state its size late and ends where it ends; that apart, line
    // by line is the same as all at once.
    for path in broken_films() {
        if path.extension().unwrap() != "jsonl" {
            continue;
        }
        let text = std::fs::read(&path).unwrap();
        let mut stream = FilmStream::new("stdin", Path::new(FOLDER), false);
        let refused = text
            .split_inclusive(|b| *b == b'\n')
            .any(|line| stream.push_line(line).is_err());
        assert!(refused || stream.finish().is_err(), "{}", path.display());
    }
}

#[test]
fn a_stream_shows_the_line_at_hand() {
    let mut stream = FilmStream::new("stdin", Path::new(FOLDER), false);
    let first = br#"{"scene":0,"size":[8,8],"eye":{"position":[0,0,-2],"velocity":[0,0,1]},"aim":{"position":[0,0,0]},"angles":[60,45]}"#;
    assert_eq!(stream.push_line(first).unwrap(), Some(0..=0));
    // Frame 2 lies between the scenes: the eye reaches the aim there.
    let errors = stream.push_line(b"{\"scene\":5}\n").unwrap_err();
    insta::assert_snapshot!("stream", rendered(&errors));
    assert_eq!(stream.push_line(first).unwrap(), None);
}

#[test]
fn a_file_that_cannot_be_read_is_an_error() {
    let error = |path: &str| film::read(Path::new(path), false).unwrap_err();
    let unreadable = error("fixtures/broken/no_such_film.anim");
    assert!(matches!(
        unreadable.errors()[0].problem(),
        Problem::Unreadable { .. }
    ));
    assert!(matches!(
        error("fixtures/broken/objects/folder.anim").errors()[0].problem(),
        Problem::Unreadable { .. }
    ));
    insta::assert_snapshot!("unknown_form", rendered(&error("fixtures/broken/film.txt")));
}

#[test]
fn a_flood_of_errors_is_dammed() {
    let text = "?\n".repeat(100_000);
    let errors = film::anim::parse("flood.anim", text.as_bytes(), Path::new("."), false);
    let errors = errors.unwrap_err();
    assert_eq!(errors.errors().len(), 1001);
    let last = errors.errors().last().unwrap().problem();
    assert!(matches!(last, Problem::TooMany { more } if *more >= 99_000));
}
