//! A folder of the air's finished tables, so that no program builds the same air twice.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use himmel_gpu::SkyRenderer;

use crate::error::{Error, Result};
use crate::picture::save_bytes;

/// Files that a folder holds, at most: half a megabyte each at `high`.
const MOST_FILES: usize = 64;

/// Saved tables by their key, in a folder.
///
/// ```no_run
/// # fn host(renderer: &mut himmel::SkyRenderer) -> himmel::Result<()> {
/// let cache = himmel::TablesCache::in_folder("cache".as_ref());
/// if !cache.load(renderer) {
///     // … frames that build the tables, submitted, until renderer.rebuilding() is None …
///     cache.store(renderer)?;
/// }
/// # Ok(()) }
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TablesCache {
    folder: PathBuf,
}

impl TablesCache {
    /// In a folder that is made when it is needed.
    pub fn in_folder(folder: &Path) -> Self {
        Self { folder: folder.into() }
    }

    /// Where the platform keeps caches (on Linux `~/.cache/himmel`); `None` where it has no such place.
    pub fn platform() -> Option<Self> {
        dirs::cache_dir().map(|folder| Self { folder: folder.join("himmel") })
    }

    /// Its folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Fills a renderer's tables, those of other bodies too, from their files; false where there is none, or none that fits: the renderer then builds them.
    /// A broken file is told of in the log and written anew by [`store`](Self::store).
    pub fn load(&self, renderer: &mut SkyRenderer) -> bool {
        let home = self.load_of(renderer, None);
        (0..renderer.far_air_count()).fold(home, |all, air| self.load_of(renderer, Some(air)) && all)
    }

    fn load_of(&self, renderer: &mut SkyRenderer, air: Option<usize>) -> bool {
        let Ok(path) = self.path(renderer, air) else { return false };
        let Ok(bytes) = std::fs::read(&path) else { return false };
        let loaded = match air {
            None => renderer.load_tables(&bytes),
            Some(air) => renderer.load_far_tables(air, &bytes),
        };
        match loaded {
            Ok(()) => true,
            Err(error) => {
                tracing::warn!(%error, path = %path.display(), "saved tables are not used");
                false
            }
        }
    }

    /// Writes a renderer's finished tables, under another name first, so that a file is whole or not there. The oldest files
    /// go where there are more than 64.
    pub fn store(&self, renderer: &SkyRenderer) -> Result<()> {
        let error = |source: std::io::Error| Error::Write { path: self.folder.clone(), reason: source.to_string() };
        std::fs::create_dir_all(&self.folder).map_err(error)?;
        for air in std::iter::once(None).chain((0..renderer.far_air_count()).map(Some)) {
            let read = match air {
                None => renderer.save_tables()?,
                Some(air) => renderer.save_far_tables(air)?,
            };
            save_bytes(&read.wait()?, &self.path(renderer, air)?)?;
        }
        self.tidy();
        Ok(())
    }

    /// The file of the sky's own air, or of another body's.
    fn path(&self, renderer: &SkyRenderer, air: Option<usize>) -> Result<PathBuf> {
        let key = match air {
            None => renderer.tables_key()?,
            Some(air) => renderer.far_tables_key(air)?,
        };
        Ok(self.folder.join(format!("{key}.air")))
    }

    fn tidy(&self) {
        let Ok(entries) = std::fs::read_dir(&self.folder) else { return };
        let mut files: Vec<(SystemTime, PathBuf)> = entries
            .flatten()
            .filter(|entry| entry.path().extension().is_some_and(|ending| ending == "air"))
            .filter_map(|entry| Some((entry.metadata().ok()?.modified().ok()?, entry.path())))
            .collect();
        files.sort();
        let surplus = files.len().saturating_sub(MOST_FILES);
        for (_, path) in files.drain(..surplus) {
            // Another program may have been faster.
            let _ = std::fs::remove_file(path);
        }
    }
}
