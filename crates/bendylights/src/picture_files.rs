//! Picture files of `render` and `replay`: checked before any work, then filled one AOV at a time.

use std::path::PathBuf;

use cli::OutputFile;
use light::LightInstance;
use protocol::{Aovs, RenderFormat};
use render::{Background, ExrFile, FileNeeds, PictureOrigin, Pixels, View, WantedPicture};

use crate::error::Error;

/// Files that pictures are written to.
pub struct OutputPictures {
    files: Vec<(RenderFormat, OutputFile)>,
    background: Background,
}

/// Pictures of one view to draw.
pub struct PictureJob<'a> {
    /// View, apart from its AOV.
    pub view: View,
    /// Lights that shine.
    pub lights: &'a [LightInstance],
    /// AOVs to draw, with their lights.
    pub wanted: Vec<WantedPicture>,
    /// Metadata for the header of an EXR.
    pub origin: PictureOrigin,
}

impl OutputPictures {
    /// Checks the paths. Returns an error if one of them cannot be a file of these AOVs.
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

    /// Draws each AOV once by `draw`, and writes all files.
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
