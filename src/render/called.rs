//! What the calls of a chunk have left to be read, frame by frame.

use decor_api::{AdapterError, Layer, LayerRequest, LayerShot, Picture, Region, Rendered, Window};

use super::chunk::Pass;

/// What a call over some frames has left.
pub struct Called<'r> {
    /// What it was for.
    pub pass: Pass,
    /// What was asked for; a frame may have several windows of a pass.
    pub request: &'r LayerRequest<'r>,
    /// What there is to be read.
    pub left: Left<'r>,
}

/// What there is to be read.
pub enum Left<'r> {
    /// Linear pixels.
    Layers(Rendered<'r, Layer>),
    /// Pixels as the frame's file has them.
    Pictures(Rendered<'r, Picture>),
}

/// One of them.
pub enum Drawn {
    /// Linear pixels.
    Layer(Layer),
    /// Pixels as the frame's file has them.
    Picture(Picture),
}

/// All calls of a chunk.
pub struct Calls<'r>(pub Vec<Called<'r>>);

impl Calls<'_> {
    /// Is anything drawn in a frame?
    pub fn has(&self, frame: u32) -> bool {
        let mut shots = self.0.iter().flat_map(|called| &called.request.shots);
        shots.any(|shot| shot.frame == frame)
    }

    /// What was asked for of a pass in a frame, by region.
    pub fn regions(&self, pass: Pass, frame: u32) -> Vec<Region> {
        let of_pass = self.0.iter().filter(|called| called.pass == pass);
        let shots = of_pass.flat_map(|called| &called.request.shots);
        let of_frame = shots.filter(|shot| shot.frame == frame);
        of_frame.map(|shot| shot.region.clone()).collect()
    }

    /// Reads what a pass has drawn in a frame, where that is one region.
    pub fn read(&mut self, pass: Pass, frame: u32) -> Result<Option<Drawn>, AdapterError> {
        self.read_where(pass, |shot| shot.frame == frame)
    }

    /// Reads a region that a pass has drawn in a frame.
    pub fn read_in(
        &mut self,
        pass: Pass,
        frame: u32,
        region: &Region,
    ) -> Result<Option<Drawn>, AdapterError> {
        self.read_where(pass, |shot| shot.frame == frame && shot.region == *region)
    }

    /// As [`read`](Self::read), of a pass that is never encoded.
    pub fn layer(&mut self, pass: Pass, frame: u32) -> Result<Option<Layer>, AdapterError> {
        Ok(self.read(pass, frame)?.and_then(Drawn::layer))
    }

    /// As [`read_in`](Self::read_in), of a pass that is never encoded.
    pub fn layer_in(
        &mut self,
        pass: Pass,
        frame: u32,
        region: &Region,
    ) -> Result<Option<Layer>, AdapterError> {
        Ok(self.read_in(pass, frame, region)?.and_then(Drawn::layer))
    }

    fn read_where(
        &mut self,
        pass: Pass,
        is_it: impl Fn(&LayerShot) -> bool,
    ) -> Result<Option<Drawn>, AdapterError> {
        for called in self.0.iter_mut().filter(|called| called.pass == pass) {
            let Some(shot) = called.request.shots.iter().position(&is_it) else {
                continue;
            };
            let drawn = match &mut called.left {
                Left::Layers(layers) => Drawn::Layer(layers.read(shot)?),
                Left::Pictures(pictures) => Drawn::Picture(pictures.read(shot)?),
            };
            return Ok(Some(drawn));
        }
        Ok(None)
    }
}

impl Drawn {
    /// Which part of the frame it is.
    pub fn window(&self) -> Window {
        match self {
            Self::Layer(layer) => layer.window,
            Self::Picture(picture) => picture.window,
        }
    }

    fn layer(self) -> Option<Layer> {
        match self {
            Self::Layer(layer) => Some(layer),
            Self::Picture(_) => None,
        }
    }
}
