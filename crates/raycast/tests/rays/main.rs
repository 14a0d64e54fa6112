//! Straight and bent rays against closed forms and brute force.

mod bent_paths;
mod straight_rays;
