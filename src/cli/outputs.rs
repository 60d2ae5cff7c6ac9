//! What files a frame's image goes to.

use crate::film;
use crate::output::numbered;
use crate::scene::Frame;
use std::path::{Path, PathBuf};

/// The files of one frame.
pub struct Outputs {
    image: PathBuf,
    png: Option<PathBuf>,
}

impl Outputs {
    /// `-o` and `--png` name the files of the first frame; later frames of a file get their number
    /// added.
    pub fn new(output: Option<&Path>, png: Option<&Path>, frame: &Frame, number: usize) -> Outputs {
        let of_frame = |path: &Path| numbered(path, number);
        Outputs {
            image: output.map_or_else(|| frame.options.film.output(), of_frame),
            png: png.map(of_frame),
        }
    }

    /// The image's file.
    pub fn image(&self) -> &Path {
        &self.image
    }

    /// Is the image written to the same file as the other's?
    pub fn same_image(&self, other: &Outputs) -> bool {
        same_file(&self.image, &other.image)
    }

    /// Adds the frame's number to the name of the image's file.
    pub fn number_image(&mut self, number: usize) {
        self.image = numbered(&self.image, number);
    }

    /// Can all of them be written, as far as is known before rendering?
    pub fn check(&self) -> Result<(), String> {
        for path in self.paths() {
            film::check_output(path).map_err(|e| e.to_string())?;
        }
        let Some(png) = &self.png else { return Ok(()) };
        if !png
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("png"))
        {
            return Err(format!(
                "--png {}: expected a name ending in .png",
                png.display()
            ));
        }
        if same_file(png, &self.image) {
            let png = png.display();
            return Err(format!(
                "--png {png}: the image itself is written there already"
            ));
        }
        Ok(())
    }

    /// The image, then the PNG beside it.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        [Some(self.image.as_path()), self.png.as_deref()]
            .into_iter()
            .flatten()
    }
}

/// Do two names, whose folders exist, mean one file?
fn same_file(a: &Path, b: &Path) -> bool {
    let resolved = |path: &Path| {
        let folder = path.parent().filter(|f| !f.as_os_str().is_empty());
        let folder = folder.unwrap_or(Path::new(".")).canonicalize().ok()?;
        Some(folder.join(path.file_name()?))
    };
    a == b || (resolved(a).is_some() && resolved(a) == resolved(b))
}
