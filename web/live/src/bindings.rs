//! Bindings of the page's worker.

use crate::browser_gpu::LiveShader;
use crate::description::describe_scene;
use crate::gpu_comparison::compare_with_gpu;
use crate::gpu_stages::check_stages;
use crate::request::LiveRequest;
use crate::solve::LiveScene;
use common::Error;
use common::file::keep_in_memory;
use js_sys::{Function, Promise};
use oracle::solve::progress::ProgressMonitor;
use std::ops::ControlFlow;
use std::path::Path;
use wasm_bindgen::prelude::{JsError, JsValue, wasm_bindgen};
use wasm_bindgen_futures::JsFuture;

/// Gives the program a file.
#[wasm_bindgen]
pub fn give_file(name: &str, content: Vec<u8>) {
    keep_in_memory(Path::new(name), Some(content));
}

/// Takes a file away.
#[wasm_bindgen]
pub fn take_file(name: &str) {
    keep_in_memory(Path::new(name), None);
}

/// Says what the browser tells of its GPU: its name, and whether the CPU stands in for it.
#[wasm_bindgen]
pub fn describe_adapter(name: String, software: bool) {
    crate::browser_gpu::describe_adapter(name, software);
}

/// Lists the shaders that the page can change, as JSON.
///
/// Errors: none that is known.
#[wasm_bindgen]
pub fn list_shaders() -> Result<String, JsError> {
    Ok(serde_json::to_string(&crate::browser_gpu::list_shaders())?)
}

/// Lists the cases of the failure atlas, as JSON.
///
/// Errors: none that is known.
#[wasm_bindgen]
pub fn list_cases() -> Result<String, JsError> {
    Ok(serde_json::to_string(&crate::case::list_cases())?)
}

/// Lists the faults that the page can plant, as JSON.
///
/// Errors: none that is known.
#[wasm_bindgen]
pub fn list_faults() -> Result<String, JsError> {
    Ok(serde_json::to_string(&crate::fault::LIVE_FAULTS)?)
}

/// A scene that the page shows.
#[wasm_bindgen]
pub struct OpenScene(LiveScene);

#[wasm_bindgen]
impl OpenScene {
    /// Opens a scene of the given files, in the light of a panorama if one is named.
    ///
    /// Errors: one line for the reader.
    #[wasm_bindgen(constructor)]
    pub fn open(name: &str, panorama: Option<String>) -> Result<OpenScene, JsError> {
        let opened = LiveScene::open(name, panorama.as_deref());
        opened.map(OpenScene).map_err(|error| explain(&error))
    }

    /// Opens the scene of a case of the failure atlas at a value of its parameter, in the light of a panorama if one is named.
    ///
    /// Errors: one line for the reader.
    pub fn open_case(name: &str, value: f64, panorama: Option<String>) -> Result<OpenScene, JsError> {
        let opened = LiveScene::open_case(name, value, panorama.as_deref());
        opened.map(OpenScene).map_err(|error| explain(&error))
    }

    /// Describes the scene, as JSON.
    ///
    /// Errors: none that is known.
    pub fn describe(&self) -> Result<String, JsError> {
        Ok(serde_json::to_string(&describe_scene(&self.0))?)
    }

    /// Solves what the request asks for. `show` receives the finished share, and after a slice of the shots returns a promise
    /// of whether the solve is to stop. Returns JSON.
    ///
    /// Errors: one line for the reader.
    pub async fn solve(&mut self, request: &str, show: Function) -> Result<String, JsError> {
        let report = |share: f64| show.call1(&JsValue::NULL, &share.into());
        let callback = |_: &str, share: f64| {
            // A report that fails shows nothing; the solve goes on.
            let _ = report(share);
            ControlFlow::Continue(())
        };
        let pause = async |share: f64| {
            let answer = match report(share) {
                Ok(promise) => JsFuture::from(Promise::resolve(&promise)).await,
                Err(error) => Err(error),
            };
            match answer.is_ok_and(|stop| stop.is_truthy()) {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        };
        let request = LiveRequest::parse(request).map_err(|error| explain(&error))?;
        let progress = ProgressMonitor::new(&callback);
        let solve = self.0.solve(&request, &progress, pause).await;
        Ok(serde_json::to_string(&solve.map_err(|error| explain(&error))?)?)
    }

    /// Makes the latest solve again on the GPU; `shaders` is JSON. Returns JSON.
    ///
    /// Errors: one line for the reader.
    pub async fn compare_with_gpu(&self, shaders: &str) -> Result<String, JsError> {
        let shaders: Vec<LiveShader> = serde_json::from_str(shaders)?;
        let compared = compare_with_gpu(&self.0, &shaders).await;
        Ok(serde_json::to_string(&compared.map_err(|error| explain(&error))?)?)
    }

    /// Checks all stages of the GPU's solvers on the texels of the latest solve; `shaders` is JSON. Returns JSON.
    ///
    /// Errors: one line for the reader.
    pub async fn check_stages(&self, visibility: &str, pixels: u32, shaders: &str) -> Result<String, JsError> {
        let shaders: Vec<LiveShader> = serde_json::from_str(shaders)?;
        let report = check_stages(&self.0, (visibility, pixels), &shaders).await;
        Ok(serde_json::to_string(&report.map_err(|error| explain(&error))?)?)
    }

    /// Encodes the texels of the latest solve as OpenEXR.
    ///
    /// Errors: one line for the reader.
    pub fn encode_lightmap(&self) -> Result<Vec<u8>, JsError> {
        self.0.encode_lightmap().map_err(|error| explain(&error))
    }

    /// Encodes the scene of the latest solve with its light as binary glTF.
    ///
    /// Errors: one line for the reader.
    pub fn encode_glb(&self) -> Result<Vec<u8>, JsError> {
        self.0.encode_glb().map_err(|error| explain(&error))
    }

    /// Compares the latest solve with the exact answer, as JSON; `null` if there is none.
    ///
    /// Errors: one line for the reader.
    pub fn compare_with_exact(&self) -> Result<String, JsError> {
        let compared = self.0.compare_with_exact().map_err(|error| explain(&error))?;
        Ok(serde_json::to_string(&compared)?)
    }

    /// Estimates the error of the latest solve; none if that is impossible.
    ///
    /// Errors: one line for the reader.
    pub fn estimate_error(&self) -> Result<Option<f64>, JsError> {
        self.0.estimate_error().map_err(|error| explain(&error))
    }
}

fn explain(error: &Error) -> JsError {
    JsError::new(&error.to_string())
}
