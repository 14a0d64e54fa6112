//! Files of a request for pictures.

use std::io::{Cursor, Write as _};

use light::LightInstance;
use protocol::RenderFormat;
use render::{Aov, Background, ExrFile, FileNeeds, PictureOrigin, Pixels, RenderError};
use scene::View;
use zip::write::{SimpleFileOptions, ZipWriter};
use zip::{CompressionMethod, result::ZipResult};

/// A drawn picture of a request.
pub struct DrawnPictures {
    /// View that was drawn: camera, AOV and light.
    pub view: View,
    pub lights: Vec<LightInstance>,
    /// Name of the picture's light in files, if there are pictures of several lights.
    pub light: Option<String>,
    pub pixels: Pixels,
}

/// Picture files that are being made for one request.
pub struct PictureFiles {
    background: Background,
    exr: Option<ExrFile>,
    /// PNG files by name, if PNG was requested.
    pngs: Option<Vec<(String, Vec<u8>)>>,
}

impl PictureFiles {
    /// Starts without pictures.
    pub fn new(formats: &[RenderFormat], background: Background, view: &View) -> Self {
        let size = [view.width, view.height];
        Self {
            background,
            exr: formats.contains(&RenderFormat::Exr).then(|| ExrFile::new(size)),
            pngs: formats.contains(&RenderFormat::Png).then(Vec::new),
        }
    }

    /// Returns the form in which the files need the pixels of an AOV.
    pub fn needs(&self, aov: Aov) -> FileNeeds {
        FileNeeds::of(aov, self.pngs.is_some().then_some(self.background), self.exr.is_some())
    }

    /// Adds a picture. Converting and compressing it takes a while.
    pub fn add(mut self, drawn: &DrawnPictures) -> Result<Self, RenderError> {
        let DrawnPictures { view, lights, light, pixels } = drawn;
        if let (Some(exr), Some(picture)) = (&mut self.exr, pixels.values()) {
            exr.add(view.aov, light.as_deref(), picture);
        }
        if let Some(pngs) = &mut self.pngs {
            let of_light = light.as_ref().map(|name| format!("{name}.")).unwrap_or_default();
            let png = pixels.to_png(view, lights, self.background)?;
            pngs.push((format!("{of_light}{}.png", view.aov.name()), png));
        }
        Ok(self)
    }

    /// Returns the media type and the bytes of the answer: the file, or a ZIP of several files. Compressing a large
    /// picture takes a while.
    pub fn finish(self, view: &View, origin: &PictureOrigin) -> Result<(&'static str, Vec<u8>), RenderError> {
        let exr = self.exr.map(|exr| exr.into_bytes(view, origin)).transpose()?;
        let mut pngs = self.pngs.unwrap_or_default();
        match (exr, &mut pngs[..]) {
            (Some(exr), []) => Ok(("image/x-exr", exr)),
            (None, [(_, png)]) => Ok(("image/png", std::mem::take(png))),
            (exr, _) => {
                let exr = exr.map(|exr| ("picture.exr".to_owned(), exr));
                let files: Vec<_> = pngs.into_iter().chain(exr).collect();
                let zip = zipped(&files).map_err(|why| RenderError::Encode(why.to_string()))?;
                Ok(("application/zip", zip))
            }
        }
    }
}

/// Makes a ZIP of files that are compressed already.
fn zipped(files: &[(String, Vec<u8>)]) -> ZipResult<Vec<u8>> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let stored = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    for (name, bytes) in files {
        zip.start_file(name.as_str(), stored)?;
        zip.write_all(bytes)?;
    }
    Ok(zip.finish()?.into_inner())
}
