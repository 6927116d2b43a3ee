//! The engines' interface for JavaScript: a [`Page`] opens scenes and renders them into pictures of RGBA. Arguments and
//! results other than files and pixels are JSON: [`Look`] and [`Shown`].

mod look;
mod proof;
mod studio;
mod tracers;

use js_sys::{Float32Array, Uint8Array, Uint32Array};
use wasm_bindgen::prelude::*;

pub use look::{Engine, Look, LookAt, Opened, Shown, ShownLight};
pub use proof::Proof;
pub use studio::Studio;

/// A scene and its renderers.
#[wasm_bindgen]
#[derive(Debug, Default)]
pub struct Page {
    studio: Studio,
}

#[wasm_bindgen]
impl Page {
    /// Makes a page without a scene.
    #[wasm_bindgen(constructor)]
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The scenes that need no file, as JSON: a list of `{name, about, triangles}`.
    #[must_use]
    pub fn gallery() -> String {
        studio::gallery()
    }

    /// Opens a scene of the gallery, `demo:NAME` or `demo:NAME?triangles=N`, and returns [`Opened`] in JSON.
    ///
    /// # Errors
    /// Where there is none; the last scene stays.
    pub fn open_demo(&mut self, address: &str) -> Result<String, JsError> {
        self.studio.open_demo(address).map(|opened| json(&opened)).map_err(error)
    }

    /// Opens the scene `name`, one of files given by their paths and contents, and returns [`Opened`] in JSON.
    ///
    /// # Errors
    /// Where the file is broken, or needs a missing file; the last scene stays.
    #[allow(clippy::needless_pass_by_value, reason = "JavaScript gives lists away")]
    pub fn open_files(&mut self, name: &str, paths: Vec<String>, contents: Vec<Uint8Array>) -> Result<String, JsError> {
        let files = paths.into_iter().zip(contents.iter().map(Uint8Array::to_vec));
        self.studio.open_files(name, files).map(|opened| json(&opened)).map_err(error)
    }

    /// Renders a moment of the scene by a [`Look`] in JSON, and returns a [`Shown`] in JSON.
    ///
    /// # Errors
    /// Where there is no scene, or `look` can't be rendered.
    pub async fn render(&mut self, look: String) -> Result<String, JsError> {
        self.studio.render(&read(&look)?).await.map(|shown| json(&shown)).map_err(error)
    }

    /// Opens the GPU that the browser prefers, for looks that ask for it, and returns its name.
    ///
    /// # Errors
    /// Where the browser has no WebGPU, or its device lacks a needed feature.
    #[cfg(target_arch = "wasm32")]
    pub async fn open_gpu(&mut self) -> Result<String, JsError> {
        use umbrage::gpu::{DeviceLimits, Gpu};
        let gpu =
            Gpu::open_in_browser(DeviceLimits::Adapter).await.map_err(|cause| JsError::new(&cause.to_string()))?;
        let name = gpu.adapter().name.clone();
        let renderer = umbrage::Renderer::with_gpu(gpu).map_err(|cause| JsError::new(&cause.to_string()))?;
        self.studio.use_gpu(renderer);
        Ok(name)
    }

    /// Number of pixels of the last picture, which a GPU rendered by `look`, in which the CPU's triangle or light masks
    /// differ.
    ///
    /// # Errors
    /// As [`Page::render`].
    pub async fn differing(&mut self, look: String) -> Result<u32, JsError> {
        self.studio.differing(&read(&look)?).await.map_err(error)
    }

    /// The last picture: four bytes a pixel, opaque RGBA, in rows from the upper left corner.
    #[must_use]
    pub fn pixels(&self) -> Uint8Array {
        Uint8Array::from(self.studio.pixels())
    }

    /// The triangle at each pixel of the last picture, in rows from the upper left corner; 4294967295 for a miss.
    #[must_use]
    pub fn hits(&self) -> Uint32Array {
        Uint32Array::from(self.studio.hits())
    }

    /// The triangles of the moment that was rendered last: three corners each, as x, y and z in world space.
    #[must_use]
    pub fn triangles(&self) -> Float32Array {
        Float32Array::from(&self.studio.triangles()[..])
    }

    /// A [`Proof`] of the last picture in JSON: hashes to compare with other machines'.
    #[must_use]
    pub fn proof(&self) -> String {
        json(&self.studio.proof())
    }
}

fn read(look: &str) -> Result<Look, JsError> {
    serde_json::from_str(look).map_err(|cause| JsError::new(&format!("the look: {cause}")))
}

fn json(value: &impl serde::Serialize) -> String {
    // No map in them has keys that aren't strings.
    serde_json::to_string(value).unwrap_or_default()
}

#[allow(clippy::needless_pass_by_value, reason = "as `map_err` calls it")]
fn error(cause: String) -> JsError {
    JsError::new(&cause)
}
