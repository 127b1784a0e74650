//! The folder of one call of POV-Ray: the scene's files, and what the call leaves.

use std::fs::File;
use std::io::{BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};

use decor_api::{AdapterError, LayerRequest, NativeFile, RunContext, SceneText};

/// Some blocks' records.
const BUFFER: usize = 1 << 16;

/// A folder for one call. It goes with the value, unless it is kept.
pub struct Folder {
    path: PathBuf,
    _temporary: Option<tempfile::TempDir>,
}

impl Folder {
    /// Makes the folder, named after `label`, and writes the files of a scene.
    pub fn new(run: &RunContext, label: &str, text: &SceneText) -> Result<Self, AdapterError> {
        let folder = if run.keep {
            let path = run.work.join(label);
            std::fs::create_dir_all(&path).map_err(AdapterError::io(&path))?;
            Self {
                path,
                _temporary: None,
            }
        } else {
            let temporary = tempfile::Builder::new()
                .prefix(&format!("{label}-"))
                .tempdir_in(&run.work)
                .map_err(AdapterError::io(&run.work))?;
            Self {
                path: temporary.path().to_owned(),
                _temporary: Some(temporary),
            }
        };
        for (name, bytes) in &text.files {
            folder.write(name, bytes)?;
        }
        Ok(folder)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A file in it.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    fn write(&self, name: &str, bytes: &[u8]) -> Result<(), AdapterError> {
        let path = self.file(name);
        std::fs::write(&path, bytes).map_err(AdapterError::io(&path))
    }

    /// Makes the folders of `files` library paths: what a scene reads besides
    /// its text (images, height fields) lies there. Debian's POV-Ray may read
    /// only below its working folder, so they are linked into it.
    pub fn library_switches<'f>(
        &self,
        files: impl Iterator<Item = &'f NativeFile>,
    ) -> Result<Vec<String>, AdapterError> {
        let mut folders: Vec<&Path> = Vec::new();
        for file in files {
            for folder in [file.path.parent().unwrap_or(Path::new("/")), &file.root] {
                if !folders.contains(&folder) {
                    folders.push(folder);
                }
            }
        }
        let mut switches = Vec::new();
        for (k, folder) in folders.into_iter().enumerate() {
            let name = format!("library_{k}");
            let link = self.file(&name);
            match std::os::unix::fs::symlink(folder, &link) {
                Err(error) if error.kind() != std::io::ErrorKind::AlreadyExists => {
                    return Err(AdapterError::Io {
                        path: link,
                        source: error,
                    });
                }
                _ => {}
            }
            switches.push(format!("+L{name}"));
        }
        Ok(switches)
    }

    /// A kept folder holds text and logs; the renderer's intermediate pictures
    /// would fill a disk.
    pub fn remove_pictures(&self) {
        let Ok(entries) = std::fs::read_dir(&self.path) else {
            return;
        };
        for entry in entries.flatten() {
            let path = entry.path();
            if path.extension().is_some_and(|e| e == "pov-state") {
                let _ = std::fs::remove_file(path);
            }
        }
    }
}

/// All renderer-native files that a request reads.
pub fn native_files<'r>(request: &'r LayerRequest<'_>) -> impl Iterator<Item = &'r NativeFile> {
    let around = request
        .shots
        .first()
        .into_iter()
        .flat_map(|shot| shot.scene.includes.iter().chain(&shot.scene.sky));
    around.chain(fragments(request.prototypes))
}

/// The files of all fragments of a table.
pub fn fragments(table: &decor_api::PrototypeTable) -> impl Iterator<Item = &NativeFile> {
    table
        .iter()
        .filter_map(|(_, prototype)| match &prototype.geometry {
            decor_api::Geometry::Fragment(fragment) => Some(&fragment.file),
            decor_api::Geometry::Neutral(_) => None,
        })
}

/// The switches of a call whose pixels are read from the state file. The picture itself
/// is not read: the format is the one that takes least time. At 1024 × 1024 a black
/// picture costs 0.06 s of CPU in all as RGBE, 0.11 as PNG, 0.13 as PPM.
pub fn state_switches(name: &str) -> Vec<String> {
    vec!["+FH".into(), format!("+O{name}.{SCRATCH}"), "+C".into()]
}

/// The ending of the picture beside a state file.
const SCRATCH: &str = "hdr";

/// Writes the state file of the frame that POV-Ray names `name` and `suffix`.
/// POV-Ray takes over what it says, and deletes it when the frame is done: a
/// second link to it survives.
pub fn keep_state(
    folder: &Folder,
    name: &str,
    suffix: &str,
    says: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<(), AdapterError> {
    let path = folder.file(&format!("{name}{suffix}.pov-state"));
    let kept = folder.file(&format!("{name}{suffix}.kept"));
    let write = || {
        let mut file = BufWriter::with_capacity(BUFFER, File::create(&path)?);
        says(&mut file)?;
        file.flush()
    };
    write().map_err(AdapterError::io(&path))?;
    // In a kept folder there may be one of an earlier run.
    let _ = std::fs::remove_file(&kept);
    let _ = std::fs::remove_file(folder.file(&format!("{name}{suffix}.{SCRATCH}")));
    std::fs::hard_link(&path, &kept).map_err(AdapterError::io(&kept))
}

/// Opens what became of a state file, and removes it and its picture: frames
/// are many, and what was read of them is not kept.
pub fn take_state(
    folder: &Folder,
    name: &str,
    suffix: &str,
) -> Result<(PathBuf, BufReader<File>), AdapterError> {
    let path = folder.file(&format!("{name}{suffix}.kept"));
    let file = File::open(&path).map_err(|error| unreadable(&path, &error))?;
    let _ = std::fs::remove_file(&path);
    let _ = std::fs::remove_file(folder.file(&format!("{name}{suffix}.{SCRATCH}")));
    Ok((path, BufReader::with_capacity(BUFFER, file)))
}

/// Reads what POV-Ray wrote.
pub fn read_file(path: &Path) -> Result<Vec<u8>, AdapterError> {
    std::fs::read(path).map_err(|error| unreadable(path, &error))
}

fn unreadable(path: &Path, error: &std::io::Error) -> AdapterError {
    AdapterError::BadOutput {
        program: "povray".into(),
        file: path.to_owned(),
        reason: format!("it cannot be read: {error}"),
    }
}
