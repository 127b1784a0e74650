//! What POV-Ray alone gives of a plain scene, and whether decor's frames are the
//! same.
#![allow(dead_code)]

use std::path::{Path, PathBuf};
use std::process::Command;

/// POV-Ray alone, in a folder.
pub fn povray(folder: &Path, words: &[&str]) {
    let program = std::env::var("DECOR_POVRAY").unwrap_or_else(|_| "povray".into());
    let call = || {
        Command::new(&program)
            .args(words)
            .args(["-D", "-V", "+WT1"])
            .current_dir(folder)
            .output()
            .expect("POV-Ray is installed")
    };
    let mut ended = call();
    if String::from_utf8_lossy(&ended.stderr).contains("worker thread startup") {
        // The machine was too busy: that says nothing of the scene.
        ended = call();
    }
    let said = String::from_utf8_lossy(&ended.stderr);
    assert!(ended.status.success(), "povray {words:?}: {said}");
}

/// The pictures of a folder, by name.
pub fn pictures(folder: &Path) -> Vec<PathBuf> {
    const ENDINGS: &[&str] = &["png", "ppm", "tga", "jpg", "bmp", "exr", "hdr"];
    let entries = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().path());
    let is_picture = |path: &PathBuf| {
        path.extension()
            .is_some_and(|e| ENDINGS.iter().any(|known| e == *known))
    };
    let mut list: Vec<PathBuf> = entries.filter(is_picture).collect();
    list.sort();
    list
}

/// A PNG's pixels, alpha and all; another file but for the time in it.
pub fn content(path: &Path) -> Vec<u8> {
    let mut bytes = std::fs::read(path).unwrap();
    let ending = path.extension().unwrap().to_str().unwrap();
    if ending == "tga" {
        // The footer says where the pixels end; the time follows them.
        let footer = bytes.len() - 26;
        let end = u32::from_le_bytes(bytes[footer..footer + 4].try_into().unwrap());
        assert!(end > 18, "{}", path.display());
        bytes.truncate(end as usize);
    }
    if ending != "png" {
        for at in 0..bytes.len().saturating_sub(24) {
            if bytes[at..].starts_with(b"20") && bytes[at + 4] == b'-' && bytes[at + 7] == b'-' {
                let end = bytes[at..at + 24].iter().position(|b| *b == b'Z');
                bytes[at..at + end.unwrap_or(0)].fill(b'x');
            }
        }
        return bytes;
    }
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes))
        .read_info()
        .unwrap();
    let mut data = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut data).unwrap();
    data.extend(format!("{info:?}").bytes());
    data
}

/// The two folders hold the same pictures under the same names.
pub fn assert_same(ours: &Path, its: &Path, frames: usize) {
    let names = |folder: &Path| -> Vec<_> {
        let list = pictures(folder);
        list.iter()
            .map(|p| p.file_name().unwrap().to_owned())
            .collect()
    };
    assert_eq!(names(ours), names(its));
    assert_eq!(names(ours).len(), frames);
    for name in names(ours) {
        let same = content(&ours.join(&name)) == content(&its.join(&name));
        assert!(same, "{} differs", name.to_string_lossy());
    }
}
