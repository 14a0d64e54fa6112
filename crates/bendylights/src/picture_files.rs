//! Picture files that `render` and `replay` write: refused before any work is done, filled quantity by quantity.

use std::path::PathBuf;

use cli::OutputFile;
use light::LightInstance;
use protocol::{Aovs, RenderFormat};
use render::{Background, ExrFile, FileNeeds, PictureOrigin, Pixels, View, WantedPicture};

use crate::error::Error;

/// Where pictures go.
pub struct OutputPictures {
    files: Vec<(RenderFormat, OutputFile)>,
    background: Background,
}

/// The pictures of one view, and what they are of.
pub struct PictureJob<'a> {
    /// The view but for its quantity.
    pub view: View,
    /// The lights that shine.
    pub lights: &'a [LightInstance],
    /// What of it is drawn.
    pub wanted: Vec<WantedPicture>,
    /// What the header of an EXR says.
    pub origin: PictureOrigin,
}

impl OutputPictures {
    /// Refuses what cannot become such files.
    pub fn create(paths: &[PathBuf], aovs: &Aovs, background: Background) -> Result<Self, Error> {
        let mut files = Vec::new();
        for path in paths {
            let format = match path.extension().unwrap_or_default().to_ascii_lowercase().to_str() {
                Some("png") => RenderFormat::Png,
                Some("exr") => RenderFormat::Exr,
                _ => return Err(Error::UnknownFormat(path.clone())),
            };
            if format == RenderFormat::Png && aovs.each().len() > 1 {
                return Err(Error::OneInPng(path.clone()));
            }
            files.push((format, OutputFile::create(path)?));
        }
        Ok(Self { files, background })
    }

    /// Has each quantity drawn by `draw`, once, and writes all files of it.
    pub fn write(
        &self,
        pictures: &PictureJob,
        mut draw: impl FnMut(&View, FileNeeds) -> Result<Pixels, Error>,
    ) -> Result<(), Error> {
        let PictureJob { view, lights, wanted, origin } = pictures;
        let wants = |format| self.files.iter().any(|(of, _)| *of == format);
        let mut exr = wants(RenderFormat::Exr).then(|| ExrFile::new([view.width, view.height]));
        let mut png = Vec::new();
        for WantedPicture { aov, light, name } in wanted {
            let view = View { aov: *aov, light: *light, ..view.clone() };
            let background = wants(RenderFormat::Png).then_some(self.background);
            let pixels = draw(&view, FileNeeds::of(*aov, background, exr.is_some()))?;
            if let (Some(exr), Some(picture)) = (&mut exr, pixels.values()) {
                exr.add(*aov, name.as_deref(), picture);
            }
            if wants(RenderFormat::Png) {
                png = pixels.to_png(&view, lights, self.background)?;
            }
        }
        let exr = exr.map(|exr| exr.into_bytes(view, origin)).transpose()?.unwrap_or_default();
        for (format, output) in &self.files {
            output.write(match format {
                RenderFormat::Png => &png,
                RenderFormat::Exr => &exr,
            })?;
        }
        Ok(())
    }
}
