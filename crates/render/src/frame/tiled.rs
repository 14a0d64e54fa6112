//! Pictures drawn in tiles, piece by piece, so that other pictures can come between.

use std::cell::Cell;
use std::time::{Duration, Instant};

use light::LightInstance;
use scene::{Aov, View};

use super::backend::FrameBackend;
use super::memory::{MemoryKind, Reservation};
use super::pass_runs::{Cause, Pass};
use super::pause::DrawnPiece;
use super::targets::Targets;
use super::tile::{Tile, Tiling, pixel_count};
use super::{CheckedPicture, Frame, position};
use crate::{FileNeeds, Picture, Pixels, RenderError};

/// Progress of a picture, counted in samples: each sample of each pixel counts as one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleProgress {
    pub done: u64,
    /// Number of samples of the whole picture.
    pub total: u64,
}

/// A picture in progress; [`crate::TiledPicture`] is the public form.
#[derive(Debug)]
pub(crate) struct TiledRequest {
    view: View,
    /// Checked request of the picture.
    pub drawing: CheckedPicture,
    pixels: Pixels,
    /// Number of samples in finished tiles.
    finished_samples: u64,
    tile_samples: u64,
}

/// Device memory and progress of a picture in tiles.
#[derive(Debug)]
pub(crate) struct TiledWork<B: FrameBackend> {
    tiling: Tiling,
    targets: Option<Targets<B>>,
    tile_memory: Option<Reservation>,
    _pixels_memory: Reservation,
    /// Time of the longest piece of work on this tile that grew with its number of pixels.
    longest_piece: Duration,
}

impl TiledRequest {
    /// Begins a picture of the beauty of `view` under `lights` for a screen, regardless of `view.aov`. Nothing is drawn
    /// yet.
    pub fn for_screen(view: &View, lights: &[LightInstance]) -> Result<Self, RenderError> {
        let bytes = vec![0; 4 * view.width as usize * view.height as usize];
        let pixels = Pixels::Display { width: view.width, height: view.height, bytes };
        Self::new(&View { aov: Aov::Beauty, ..view.clone() }, lights, pixels)
    }

    /// Begins a picture of `view` under `lights`, in the form that files need. Nothing is drawn yet.
    pub fn for_files(view: &View, lights: &[LightInstance], needs: FileNeeds) -> Result<Self, RenderError> {
        if needs == FileNeeds::Display {
            return Self::for_screen(view, lights);
        }
        let count = view.width as usize * view.height as usize;
        let picture = Picture { width: view.width, height: view.height, pixels: vec![[0.0; 4]; count] };
        let pixels = match needs {
            FileNeeds::Both => Pixels::Both(picture, vec![0; 4 * count]),
            FileNeeds::Display | FileNeeds::Values => Pixels::Raw(picture),
        };
        Self::new(view, lights, pixels)
    }

    fn new(view: &View, lights: &[LightInstance], pixels: Pixels) -> Result<Self, RenderError> {
        let drawn = View { aov: position::rendered_aov(view.aov), ..view.clone() };
        let drawing = CheckedPicture::new(&drawn, lights)?;
        Ok(Self { view: view.clone(), drawing, pixels, finished_samples: 0, tile_samples: 0 })
    }

    pub fn progress(&self) -> SampleProgress {
        let CheckedPicture { view, samples, .. } = &self.drawing;
        SampleProgress {
            done: self.finished_samples + self.tile_samples,
            total: u64::from(*samples) * pixel_count([view.width, view.height]),
        }
    }

    /// Returns the pixels drawn so far.
    pub fn into_pixels(self) -> Pixels {
        let Self { view, mut pixels, .. } = self;
        if let (Aov::Position, Pixels::Raw(picture)) = (view.aov, &mut pixels) {
            position::from_depths(&view, picture);
        }
        pixels
    }

    /// True for a wireframe, which does not use the camera and has no tiles.
    fn is_whole(&self) -> bool {
        self.drawing.view.aov == Aov::Wireframe
    }
}

impl<B: FrameBackend> Frame<B> {
    /// Does the work of [`crate::Renderer::render_for_files`].
    pub fn render_for_files(
        &mut self,
        view: &View,
        lights: &[LightInstance],
        needs: FileNeeds,
        mut sampled: impl FnMut(SampleProgress),
    ) -> Result<Pixels, RenderError> {
        let (mut picture, mut work) = (TiledRequest::for_files(view, lights, needs)?, None);
        self.run_or_discard(view.slot, |frame| {
            frame.backend.host().memory.begin_picture();
            loop {
                let finished = frame.draw_piece(&mut picture, &mut work, Duration::MAX, &|| false)?;
                sampled(picture.progress());
                if finished {
                    frame.shadow_maps.finish(view.slot);
                    return Ok(picture.into_pixels());
                }
            }
        })
    }

    /// Does the work of [`crate::Renderer::advance_tiled`].
    pub fn advance_tiled(
        &mut self,
        picture: &mut TiledRequest,
        work: &mut Option<TiledWork<B>>,
        aim: Duration,
    ) -> Result<bool, RenderError> {
        let slot = picture.drawing.view.slot;
        let until = Instant::now().checked_add(aim);
        self.run_or_discard(slot, |frame| {
            frame.backend.host().memory.begin_picture();
            loop {
                let over = || until.is_some_and(|until| Instant::now() >= until);
                let finished = frame.draw_piece(picture, work, aim, &over)?;
                if finished {
                    frame.shadow_maps.finish(slot);
                }
                if finished || over() {
                    return Ok(finished);
                }
            }
        })
    }

    /// Draws a sample of a tile, or a part of it if `over` returns true. Returns true if the picture is finished.
    fn draw_piece(
        &mut self,
        picture: &mut TiledRequest,
        work: &mut Option<TiledWork<B>>,
        aim: Duration,
        over: &dyn Fn() -> bool,
    ) -> Result<bool, RenderError> {
        let whole = picture.is_whole();
        let TiledRequest { drawing, pixels, finished_samples, tile_samples, .. } = picture;
        let size = [drawing.view.width, drawing.view.height];
        let triangles = self.scene.casters.triangle_count;
        let work = work.get_or_insert_with(|| TiledWork::new(&self.backend, size, triangles, pixels));
        let Some(next) = work.tiling.tile() else { return Ok(true) };
        let tile = if whole { Tile { x: 0, y: 0, width: size[0], height: size[1] } } else { next };
        work.ensure_targets(&self.backend, tile)?;
        let Some(targets) = &mut work.targets else { return Ok(false) };

        let (since, longest) = (Cell::new(Instant::now()), Cell::new(work.longest_piece));
        let pause = |piece| {
            let took = since.replace(Instant::now()).elapsed();
            if piece == DrawnPiece::Pixels {
                longest.set(took.max(longest.get()));
            }
            over()
        };
        let sampled = targets.samples_drawn;
        let done = self.draw_sample(targets, drawing, tile, Some(&pause))?;
        if targets.samples_drawn != sampled || done {
            pause(DrawnPiece::Pixels);
        }
        work.longest_piece = longest.get();
        *tile_samples = u64::from(targets.samples_drawn) * pixel_count([tile.width, tile.height]);
        if !done {
            return Ok(false);
        }
        self.collect_tile(targets, tile, &drawing.view, pixels)?;
        *finished_samples += std::mem::take(tile_samples);
        if whole {
            return Ok(true);
        }
        work.tiling.advance(work.longest_piece, aim / PIECES_PER_TURN);
        work.longest_piece = Duration::ZERO;
        Ok(work.tiling.tile().is_none())
    }

    /// Copies a finished tile into the picture.
    fn collect_tile(
        &mut self,
        targets: &Targets<B>,
        tile: Tile,
        view: &View,
        pixels: &mut Pixels,
    ) -> Result<(), RenderError> {
        let size = [tile.width, tile.height];
        let (shown, picture) = match pixels {
            Pixels::Display { bytes, .. } => (Some(bytes), None),
            Pixels::Raw(picture) => (None, Some(picture)),
            Pixels::Both(picture, bytes) => (Some(bytes), Some(picture)),
        };
        if let Some(picture) = picture {
            let drawn = self.backend.read_radiance(&targets.drawn, size)?;
            let columns = (tile.x as usize, tile.width as usize);
            copy_rows(&mut picture.pixels, view.width as usize, &drawn, columns, tile.y);
        }
        if let Some(bytes) = shown {
            let drawn = self.backend.show_radiance(&targets.drawn, size, view.exposure)?;
            self.pass_runs.note(Pass::Display, None, Cause::NotKept);
            let columns = (4 * tile.x as usize, 4 * tile.width as usize);
            copy_rows(bytes, 4 * view.width as usize, &drawn, columns, tile.y);
        }
        Ok(())
    }
}

/// Number of pieces of work that should fit into the time given to `Renderer::advance_tiled`, so that it ends close
/// to that time.
const PIECES_PER_TURN: u32 = 2;

/// Copies the rows of a tile, `count` columns from column `from` on, into the rows of a picture.
fn copy_rows<T: Copy>(picture: &mut [T], row: usize, tile: &[T], (from, count): (usize, usize), top: u32) {
    for (y, line) in tile.chunks_exact(count).enumerate() {
        let at = (top as usize + y) * row + from;
        picture[at..at + count].copy_from_slice(line);
    }
}

impl<B: FrameBackend> TiledWork<B> {
    fn new(backend: &B, size: [u32; 2], triangles: u32, pixels: &Pixels) -> Self {
        let bytes = match pixels {
            Pixels::Display { bytes, .. } => bytes.len(),
            Pixels::Raw(picture) => size_of_val(&picture.pixels[..]),
            Pixels::Both(picture, bytes) => size_of_val(&picture.pixels[..]) + bytes.len(),
        };
        Self {
            tiling: Tiling::new(size, triangles),
            targets: None,
            tile_memory: None,
            _pixels_memory: backend.host().memory.reserve(MemoryKind::Tiled, bytes as u64),
            longest_piece: Duration::ZERO,
        }
    }

    /// Makes targets that are at least as large as `tile`, and not much larger, unless the present ones are.
    fn ensure_targets(&mut self, backend: &B, tile: Tile) -> Result<(), RenderError> {
        let (width, height) = (tile.width, tile.height);
        backend.check_picture_side(width.max(height))?;
        let most = 2 * pixel_count([width, height]);
        let fits = self.targets.as_ref().is_some_and(|targets| {
            targets.size[0] >= width && targets.size[1] >= height && pixel_count(targets.size) <= most
        });
        if !fits {
            // Frees the old ones first, so that two never coexist.
            (self.targets, self.tile_memory) = (None, None);
            backend.free_dropped_memory();
            let bytes = B::max_target_bytes([width, height]);
            self.tile_memory = Some(backend.host().memory.reserve(MemoryKind::Tiled, bytes));
            self.targets = Some(Targets::new([width, height]));
        }
        Ok(())
    }
}
