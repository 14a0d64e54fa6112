//! Pictures drawn in tiles, piece by piece, so that other pictures can come between.

use std::cell::Cell;
use std::time::{Duration, Instant};

use light::LightInstance;

use crate::memory::{MemoryKind, Reservation};
use crate::pause::DrawnPiece;
use crate::renderer::CheckedPicture;
use crate::targets::{Targets, bytes_of};
use crate::tile::{Tile, Tiling, pixel_count};
use crate::{Aov, FileNeeds, Gpu, Picture, Pixels, RenderError, Renderer, View, position};

/// Progress of a picture, counted in samples: each sample of each pixel counts as one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleProgress {
    pub done: u64,
    /// Number of samples of the whole picture.
    pub total: u64,
}

/// A picture in progress. Each tile is drawn with all its samples before the next. So the picture needs the memory of
/// one tile and of the finished pixels, regardless of its size and number of samples.
///
/// It has the pixels of [`Renderer::render`], except for the rasterizer's arithmetic at another position on the target.
/// Dropping it cancels it; [`Renderer::drop_view`] of its slot frees the rest.
#[derive(Debug)]
pub struct TiledPicture {
    view: View,
    /// Checked request of the picture.
    drawing: CheckedPicture,
    pixels: Pixels,
    /// Targets and progress; `None` until drawing begins.
    work: Option<TiledWork>,
}

/// Device memory and progress of the picture.
#[derive(Debug)]
struct TiledWork {
    tiling: Tiling,
    targets: Option<Targets>,
    tile_memory: Option<Reservation>,
    _pixels_memory: Reservation,
    /// Time of the longest piece of work on this tile that grew with its number of pixels.
    longest_piece: Duration,
    /// Number of samples in finished tiles.
    finished_samples: u64,
    tile_samples: u64,
}

impl TiledPicture {
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
        Ok(Self { view: view.clone(), drawing: CheckedPicture::new(&drawn, lights)?, pixels, work: None })
    }

    pub fn progress(&self) -> SampleProgress {
        let CheckedPicture { view, samples, .. } = &self.drawing;
        SampleProgress {
            done: self.work.as_ref().map_or(0, |work| work.finished_samples + work.tile_samples),
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

impl Renderer {
    /// Draws `view` under `lights` in the form that files need, with the values of [`Self::render`], in the memory of
    /// one tile. Calls `sampled` with the progress after each sample of a tile and at the end.
    pub fn render_for_files(
        &mut self,
        view: &View,
        lights: &[LightInstance],
        needs: FileNeeds,
        mut sampled: impl FnMut(SampleProgress),
    ) -> Result<Pixels, RenderError> {
        let mut picture = TiledPicture::for_files(view, lights, needs)?;
        self.run_or_discard(view.slot, |renderer, gpu| {
            gpu.memory.begin_picture();
            loop {
                let finished = renderer.draw_piece(gpu, &mut picture, Duration::MAX, &|| false)?;
                sampled(picture.progress());
                if finished {
                    renderer.shadow_maps.finish(view.slot);
                    return Ok(picture.into_pixels());
                }
            }
        })
    }

    /// Works on `picture` for about `aim`, until the current piece of work is done: a shadow map, or one light over a
    /// tile. The time of these pieces determines the sizes of tiles. Returns true if the picture is finished.
    ///
    /// After an error the picture is unusable.
    pub fn advance_tiled(&mut self, picture: &mut TiledPicture, aim: Duration) -> Result<bool, RenderError> {
        let slot = picture.drawing.view.slot;
        let until = Instant::now().checked_add(aim);
        self.run_or_discard(slot, |renderer, gpu| {
            gpu.memory.begin_picture();
            loop {
                let over = || until.is_some_and(|until| Instant::now() >= until);
                let finished = renderer.draw_piece(gpu, picture, aim, &over)?;
                if finished {
                    renderer.shadow_maps.finish(slot);
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
        gpu: &Gpu,
        picture: &mut TiledPicture,
        aim: Duration,
        over: &dyn Fn() -> bool,
    ) -> Result<bool, RenderError> {
        let whole = picture.is_whole();
        let TiledPicture { drawing, pixels, work, .. } = picture;
        let size = [drawing.view.width, drawing.view.height];
        let triangles = self.scene.casters.triangle_count;
        let work = work.get_or_insert_with(|| TiledWork::new(gpu, size, triangles, pixels));
        let Some(next) = work.tiling.tile() else { return Ok(true) };
        let tile = if whole { Tile { x: 0, y: 0, width: size[0], height: size[1] } } else { next };
        work.ensure_targets(gpu, tile)?;
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
        let done = self.draw_sample(gpu, targets, drawing, tile, Some(&pause))?;
        if targets.samples_drawn != sampled || done {
            pause(DrawnPiece::Pixels);
        }
        work.longest_piece = longest.get();
        work.tile_samples = u64::from(targets.samples_drawn) * pixel_count([tile.width, tile.height]);
        if !done {
            return Ok(false);
        }
        self.collect_tile(gpu, targets, tile, &drawing.view, pixels)?;
        work.finished_samples += std::mem::take(&mut work.tile_samples);
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
        gpu: &Gpu,
        targets: &Targets,
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
            let drawn = self.read_raw(gpu, targets, size)?;
            let columns = (tile.x as usize, tile.width as usize);
            copy_rows(&mut picture.pixels, view.width as usize, &drawn, columns, tile.y);
        }
        if let Some(bytes) = shown {
            let drawn = self.read_display(gpu, targets, size, view.exposure)?;
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

impl TiledWork {
    fn new(gpu: &Gpu, size: [u32; 2], triangles: u32, pixels: &Pixels) -> Self {
        let bytes = match pixels {
            Pixels::Display { bytes, .. } => bytes.len(),
            Pixels::Raw(picture) => size_of_val(&picture.pixels[..]),
            Pixels::Both(picture, bytes) => size_of_val(&picture.pixels[..]) + bytes.len(),
        };
        Self {
            tiling: Tiling::new(size, triangles),
            targets: None,
            tile_memory: None,
            _pixels_memory: gpu.memory.reserve(MemoryKind::Tiled, bytes as u64),
            longest_piece: Duration::ZERO,
            finished_samples: 0,
            tile_samples: 0,
        }
    }

    /// Makes targets that are at least as large as `tile`, and not much larger, unless the present ones are.
    fn ensure_targets(&mut self, gpu: &Gpu, tile: Tile) -> Result<(), RenderError> {
        let (width, height) = (tile.width, tile.height);
        gpu.check_picture_side(width.max(height))?;
        let most = 2 * pixel_count([width, height]);
        let fits = self.targets.as_ref().is_some_and(|targets| {
            targets.size[0] >= width && targets.size[1] >= height && pixel_count(targets.size) <= most
        });
        if !fits {
            // Frees the old ones first, so that two never coexist.
            (self.targets, self.tile_memory) = (None, None);
            gpu.free_dropped_memory();
            let bytes = bytes_of(gpu.backend(), [width, height]);
            self.tile_memory = Some(gpu.memory.reserve(MemoryKind::Tiled, bytes));
            self.targets = Some(Targets::new([width, height]));
        }
        Ok(())
    }
}
