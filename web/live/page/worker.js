// Runs the program for live.js: one answer to each message, and reports of progress in between.

import start, { OpenScene, describe_adapter, give_file, list_cases, list_faults, list_shaders, take_file } from "./program.js";

let scene = null;
let given = [];
let stopping = false;
let turn = Promise.resolve();

// Returns name and kind of the browser's GPU; null if it has none.
async function find_adapter() {
  // A browser that fails to say has none.
  const adapter = await navigator.gpu?.requestAdapter().catch(() => null);
  if (!adapter) return null;
  const { vendor, architecture, device, description } = adapter.info ?? {};
  const name = description || [vendor, architecture, device].filter(Boolean).join(" ") || "a GPU without a name";
  return { name, software: adapter.info?.isFallbackAdapter ?? adapter.isFallbackAdapter ?? false };
}

const acts = {
  // Starts the program; returns the browser's GPU.
  async start({ module }) {
    await start({ module_or_path: module });
    const adapter = await find_adapter();
    if (adapter) describe_adapter(adapter.name, adapter.software);
    return adapter;
  },

  // Opens a scene of files, which take the place of those before, or the case of that name at a value of its parameter;
  // in the light of a panorama among the files if one is named.
  open({ name, files, value, panorama }) {
    scene?.free();
    scene = null;
    given.forEach(take_file);
    given = files.map((file) => file.name);
    for (const file of files) give_file(file.name, file.content);
    scene = value === undefined ? new OpenScene(name, panorama) : OpenScene.open_case(name, value, panorama);
    return JSON.parse(scene.describe());
  },

  // Solves in slices of time. After each of them waiting messages are received, of which one may stop the solve.
  async solve({ request }, show) {
    const begin = performance.now();
    stopping = false;
    const pause = (share) => {
      show(share);
      return new Promise((done) => setTimeout(() => done(stopping)));
    };
    const solve = JSON.parse(await scene.solve(JSON.stringify(request), pause));
    return { ...solve, seconds: (performance.now() - begin) / 1000 };
  },

  stop() {
    stopping = true;
    return null;
  },

  estimate: () => scene.estimate_error() ?? null,

  exact: () => JSON.parse(scene.compare_with_exact()),

  cases: () => JSON.parse(list_cases()),

  shaders: () => JSON.parse(list_shaders()),

  faults: () => JSON.parse(list_faults()),

  async compare({ shaders }) {
    const begin = performance.now();
    const comparison = JSON.parse(await scene.compare_with_gpu(JSON.stringify(shaders)));
    return { ...comparison, seconds: (performance.now() - begin) / 1000 };
  },

  async test({ visibility, pixels, shaders }) {
    return JSON.parse(await scene.check_stages(visibility, pixels, JSON.stringify(shaders)));
  },

  lightmap: () => scene.encode_lightmap(),

  glb: () => scene.encode_glb(),
};

async function answer({ act, call, ...content }) {
  try {
    const show = (share) => self.postMessage({ call, share });
    self.postMessage({ call, answer: await acts[act](content, show) });
  } catch (error) {
    // After a fault of the program its memory cannot be trusted.
    self.postMessage({ call, message: error.message ?? String(error), broken: error instanceof WebAssembly.RuntimeError });
  }
}

// One act at a time uses the scene, also while a solve waits between two slices; a stop is not kept waiting.
self.onmessage = ({ data }) => {
  if (data.act === "stop") answer(data);
  else turn = turn.then(() => answer(data));
};
