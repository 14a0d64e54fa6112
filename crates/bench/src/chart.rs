//! Parts that all charts share: the SVG, its colors, and legends with lines and boxes.

use plotters::chart::SeriesLabelPosition;
use plotters::coord::ranged1d::AsRangedCoord;
use plotters::coord::{CoordTranslate, Shift};
use plotters::prelude::*;

use crate::BenchError;

pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// Boxed, because an error of plotters names the lifetime of its backend.
pub(crate) type ChartResult = Result<(), Box<dyn std::error::Error>>;

pub(crate) const BLUE: RGBColor = RGBColor(0x2f, 0x6d, 0xb5);
pub(crate) const ORANGE: RGBColor = RGBColor(0xe0, 0x8a, 0x1e);
pub(crate) const RED: RGBColor = RGBColor(0xd9, 0x48, 0x3b);
pub(crate) const GREEN: RGBColor = RGBColor(0x3a, 0x9a, 0x5c);
pub(crate) const VIOLET: RGBColor = RGBColor(0x7a, 0x5c, 0xa8);
pub(crate) const GREY: RGBColor = RGBColor(0xb0, 0xb0, 0xb0);
/// Color of wrong results.
pub(crate) const WRONG: RGBColor = RGBColor(0xd0, 0x00, 0x30);
/// Color of minor grid lines.
pub(crate) const FAINT: RGBAColor = RGBAColor(0, 0, 0, 0.05);

/// Draws an SVG of `size` pixels with a white background, `title` at the top and the output of `draw` below it.
pub(crate) fn svg(
    size: (u32, u32),
    title: &str,
    draw: impl FnOnce(&Area) -> ChartResult,
) -> Result<String, BenchError> {
    let mut svg = String::new();
    let drawn = || -> ChartResult {
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        root.fill(&WHITE)?;
        draw(&if title.is_empty() { root.clone() } else { root.titled(title, ("sans-serif", 18))? })?;
        Ok(root.present()?)
    };
    drawn().map_err(|why| BenchError::Chart(why.to_string()))?;
    Ok(svg)
}

/// Layout of a plot: sizes in pixels of its caption, its margin, and the labels below it and to its left.
pub(crate) struct PlotLayout {
    pub caption: u32,
    pub margin: u32,
    pub below: u32,
    pub left: u32,
}

/// Two axes of a plot.
pub(crate) type Axes<X, Y> = Cartesian2d<<X as AsRangedCoord>::CoordDescType, <Y as AsRangedCoord>::CoordDescType>;

impl PlotLayout {
    /// Begins a plot on `area` with the ranges of its axes.
    pub fn plot<'a, 'b, X: AsRangedCoord, Y: AsRangedCoord>(
        &self,
        area: &'a Area<'b>,
        caption: &str,
        x: X,
        y: Y,
    ) -> Result<ChartContext<'a, SVGBackend<'b>, Axes<X, Y>>, Box<dyn std::error::Error>> {
        let mut builder = ChartBuilder::on(area);
        builder.caption(caption, ("sans-serif", self.caption)).margin(self.margin);
        builder.x_label_area_size(self.below).y_label_area_size(self.left);
        Ok(builder.build_cartesian_2d(x, y)?)
    }
}

/// Draws the legend of a plot, in a box at `position`.
pub(crate) fn key<'a, 'b: 'a, T: CoordTranslate>(
    plot: &mut ChartContext<'a, SVGBackend<'b>, T>,
    position: SeriesLabelPosition,
) -> ChartResult {
    let mut labels = plot.configure_series_labels();
    labels.position(position).background_style(WHITE.mix(0.85)).border_style(BLACK.mix(0.3));
    Ok(labels.draw()?)
}

/// Adds a line of text with a symbol to the legend of a plot, for no series.
pub(crate) fn note<'a, 'b: 'a, T, E>(
    plot: &mut ChartContext<'a, SVGBackend<'b>, T>,
    text: &str,
    symbol: impl Fn((i32, i32)) -> E + 'a,
) -> ChartResult
where
    T: CoordTranslate,
    E: IntoDynElement<'a, SVGBackend<'b>, (i32, i32)> + 'a,
{
    plot.draw_series(std::iter::empty::<Circle<T::From, i32>>())?.label(text).legend(symbol);
    Ok(())
}

/// Returns the legend symbol of a line.
pub(crate) fn line(style: impl Into<ShapeStyle>) -> impl Fn((i32, i32)) -> PathElement<(i32, i32)> {
    let style = style.into();
    move |(x, y)| PathElement::new([(x, y), (x + 18, y)], style)
}

/// Returns the legend symbol of a box.
pub(crate) fn swatch(color: RGBColor) -> impl Fn((i32, i32)) -> Rectangle<(i32, i32)> {
    move |(x, y)| Rectangle::new([(x, y - 5), (x + 12, y + 5)], color.filled())
}

/// Returns the legend symbol of a dot.
pub(crate) fn dot(style: impl Into<ShapeStyle>) -> impl Fn((i32, i32)) -> Circle<(i32, i32), i32> {
    let style = style.into();
    move |(x, y)| Circle::new((x + 6, y), 5, style)
}

/// Returns the minimum and the maximum of positive values.
pub(crate) fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, 0.0), |(low, high), x| (low.min(x), high.max(x)))
}
