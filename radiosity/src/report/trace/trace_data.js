// Record of a solve: reads the page's arrays and repeats the shots, ΔB = Δr = ρ · F · V · B / o of the shooter, which shoots
// from its open share o. F · V and the choice of the shooters are the solver's. In a relight V of captured light is over o
// already, and below 0 where objects hide the shooter.

// Bytes of the states that are kept, so that a move to any shot takes a moment.
const KEPT_STATE_BYTES = 48e6;
// Most states that are kept.
const MAX_KEPT_STATES = 40;
// Components of a texel's vectors B and r, and of the error of B.
const STATE_BYTES_PER_TEXEL = 36;

// Reads the numbers of plane `plane` of a shooter's links: differences from predictions by the texels before, as
// oracle/src/trace/packing.rs writes them.
function read_plane(bytes, plane, { info, faces, texels }) {
  const values = new Uint16Array(texels);
  const low = 2 * plane * texels, high = low + texels;
  let first = 0;
  for (let f = 0; f < faces; f++) {
    const [width, height, quad] = info.subarray(4 * f, 4 * f + 3);
    for (let k = 0, at = first; k < width * height; k++, at++) {
      let guess = at > 0 ? values[at - 1] : 0;
      if (quad && k >= width) {
        guess = k % width ? guess + values[at - width] - values[at - width - 1] : values[at - width];
      } else if (!quad && k > 1) {
        guess = values[at - 2];
      }
      values[at] = guess + unfold_difference(bytes[low + at], bytes[high + at]);
    }
    first += width * height;
  }
  return values;
}

class Trace {
  // Reads the arrays of a page whose viewer displays `scene`.
  static async read(element, scene) {
    const trace = Object.assign(new Trace(), JSON.parse(element.querySelector(".trace-head").textContent));
    const arrays = await inflate(decode_bytes(element.querySelector(".trace-arrays")));
    let at = 0;
    const take = (Kind, count) => { const own = new Kind(arrays.buffer, at, count); at += 4 * count; return own; };
    const words = (count) => take(Uint32Array, count);
    const floats = (count) => Array.from(take(Float32Array, count));
    trace.scene = scene;
    trace.initial_radiosity = take(Float32Array, 3 * scene.texels);
    trace.initial_residual = take(Float32Array, 3 * scene.texels);
    trace.patch_of = words(scene.texels);
    trace.patches = Array.from({ length: trace.patches }, () => {
      const [[face], [area, open, ...places]] = [words(1), floats(17)];
      const corner = (k) => places.slice(3 * k, 3 * k + 3);
      return { face, area, open, centre: corner(0), corners: [1, 2, 3, 4].map(corner) };
    });
    const rows = Array.from({ length: trace.links }, () => [...words(5), floats(12)]);
    trace.shots = Array.from({ length: trace.shots }, () => {
      const [[shooter], [r, g, b, unshot, ...energy]] = [words(1), floats(8)];
      return { shooter, patch: rows[shooter][0], is_captured: (rows[shooter][2] & 2) > 0, radiosity: [r, g, b], unshot, energy };
    });
    for (const shot of trace.shots) {
      const ranked = Array.from({ length: trace.ranked }, () => ({ patch: words(1)[0], power: floats(1)[0] }));
      shot.ranking = ranked.filter(({ patch }) => patch < trace.patches.length);
    }
    await trace.read_shooters(decode_bytes(element.querySelector(".trace-links")), rows);
    const largest = (links) => links.scale * HALVES[links.form_factors.reduce((a, b) => Math.max(a, b), 0)];
    trace.largest_form_factor = trace.links.reduce((most, links) => Math.max(most, largest(links)), 0);
    return trace;
  }

  // Reads links and item buffer of each shooter; form factors and shares stay half floats.
  async read_shooters(bytes, rows) {
    this.links = [];
    this.hemispheres = [];
    let at = 0;
    const take = (count) => { at += count; return inflate(bytes.subarray(at - count, at)); };
    for (const [, exponent, bits, link_bytes, hemisphere_bytes, frame] of rows) {
      const planes = await take(link_bytes);
      const plane = (k) => (k === 0 || bits & 1 ? read_plane(planes, k, this.scene) : null);
      // Planes of shares and occluders are left out where all texels see the whole shooter.
      const share_errors = bits & 4 ? read_plane(planes, bits & 1 ? 3 : 1, this.scene) : null;
      this.links.push({ scale: 2 ** (exponent | 0), form_factors: plane(0), shares: plane(1), occluders: plane(2), share_errors });
      const faces = await take(hemisphere_bytes);
      const pixels = faces.length / 2;
      this.hemispheres.push({
        ids: Uint16Array.from({ length: pixels }, (_, k) => faces[k] | (faces[pixels + k] << 8)),
        frame: [0, 3, 6, 9].map((k) => frame.slice(k, k + 3)),
      });
    }
  }

  // Returns shot number `n`, from 1; none before the first.
  shot(n) {
    return this.shots[n - 1];
  }

  // Returns form factor, visible share, its error and the occluding face of texel `k` in shot `n`, and the shooter's open share.
  link(n, k) {
    const { shooter, patch, is_captured } = this.shot(n);
    const links = this.links[shooter];
    const occluder = links.occluders ? links.occluders[k] : 0;
    return {
      form_factor: links.scale * HALVES[links.form_factors[k]],
      share: links.shares ? HALVES[links.shares[k]] : 1,
      open: is_captured ? 1 : this.patches[patch].open,
      occluder: occluder > 0 ? occluder - 1 : null,
      share_error: links.share_errors ? HALVES[links.share_errors[k]] : 0,
    };
  }

  // Returns the texels that the item buffer shows the shooter of shot `n`, or hides it from, and rays do not.
  wrong_texels(n) {
    const { share_errors } = n > 0 ? this.links[this.shot(n).shooter] : {};
    return share_errors ? Array.from(share_errors.keys()).filter((k) => HALVES[share_errors[k]] !== 0) : [];
  }

  // Returns whether texel `k` is one of the room into which objects are put.
  is_of_room(k) {
    return this.relight !== null && this.patches[this.patch_of[k]].face < this.relight.room_faces;
  }

  // Returns whether texel `k` shoots the light that it receives.
  shoots_again(k) {
    return this.relight === null || this.relight.reshoot || !this.is_of_room(k);
  }

  // Returns the power that is unshot after `n` shots, W.
  unshot_after(n) {
    return n > 0 ? this.shot(n).unshot : this.unshot;
  }

  // Returns absorbed, unshot, escaped and closure after `n` shots, W.
  energy_after(n) {
    return n > 0 ? this.shot(n).energy : this.initial;
  }
}

// Radiosity and residual of the texels after some shots.
class ShotState {
  // `reflectance` has three numbers a texel.
  constructor(trace, reflectance) {
    this.trace = trace;
    this.reflectance = reflectance;
    const most = Math.floor(KEPT_STATE_BYTES / (STATE_BYTES_PER_TEXEL * trace.scene.texels));
    this.stride = Math.max(1, Math.ceil(trace.shots.length / Math.min(Math.max(most, 2), MAX_KEPT_STATES)));
    this.kept = new Map();
    const right = new Float32Array(3 * trace.scene.texels);
    this.load({ done: 0, radiosity: trace.initial_radiosity, residual: trace.initial_residual, error: right });
    this.keep();
  }

  load({ done, radiosity, residual, error }) {
    this.done = done;
    this.radiosity = radiosity.slice();
    this.residual = residual.slice();
    // Part of B that rays would not have given.
    this.error = error.slice();
    // Texels of the latest shooter, and the state before its shot.
    this.cleared = new Set();
    this.before = { radiosity: radiosity.slice(), residual: residual.slice() };
  }

  keep() {
    if (this.done % this.stride === 0 && !this.kept.has(this.done)) {
      const { done, radiosity, residual, error } = this;
      this.kept.set(done, { done, radiosity: radiosity.slice(), residual: residual.slice(), error: error.slice() });
    }
  }

  // Moves to the state after `n` shots. The latest shot is always made, since the residual before it is displayed.
  move_to(n) {
    if (n === this.done) return;
    const before = Math.max(0, n - 1);
    let start = Math.floor(before / this.stride) * this.stride;
    while (!this.kept.has(start)) start -= this.stride;
    if (n < this.done || start > this.done) this.load(this.kept.get(start));
    while (this.done < n) {
      this.shoot();
      this.keep();
    }
  }

  // Makes the next shot (Table 1, lines 4 to 15).
  shoot() {
    this.done++;
    const { trace, reflectance, radiosity, residual, error } = this;
    const { shooter, patch, is_captured, radiosity: shot } = trace.shot(this.done);
    const { scale, form_factors, shares, share_errors } = trace.links[shooter];
    // A patch without an open part has links of 0.
    const open = is_captured ? 1 : trace.patches[patch].open || 1;
    this.cleared.clear();
    this.before.radiosity.set(radiosity);
    this.before.residual.set(residual);
    for (let k = 0; k < trace.scene.texels; k++) {
      // The shooter's captured light is no part of the change.
      if (trace.patch_of[k] === patch && is_captured) continue;
      if (trace.patch_of[k] === patch) {
        this.cleared.add(k);
        residual.fill(0, 3 * k, 3 * k + 3);
        continue;
      }
      if (form_factors[k] === 0) continue;
      const link = (scale * HALVES[form_factors[k]] * (shares ? HALVES[shares[k]] : 1)) / open;
      for (let c = 3 * k, channel = 0; channel < 3; c++, channel++) {
        const change = reflectance[c] * link * shot[channel];
        radiosity[c] += change;
        if (trace.shoots_again(k)) residual[c] += change;
      }
      if (!share_errors || share_errors[k] === 0) continue;
      const wrong = (scale * HALVES[form_factors[k]] * HALVES[share_errors[k]]) / open;
      for (let c = 3 * k, channel = 0; channel < 3; c++, channel++) error[c] += reflectance[c] * wrong * shot[channel];
    }
  }

  // Returns ΔB of texel `k` in the latest shot.
  change(k) {
    const { trace, done } = this;
    if (done === 0 || trace.patch_of[k] === trace.shot(done).patch) return [0, 0, 0];
    const { form_factor, share, open } = trace.link(done, k);
    return trace.shot(done).radiosity.map((b, c) => (this.reflectance[3 * k + c] * form_factor * share * b) / (open || 1));
  }

  // Returns the power that texels of these areas have gained and lost since before the first shot, W.
  gain_and_loss(areas) {
    const { initial_radiosity: before } = this.trace;
    const sums = [0, 0];
    for (let c = 0; c < before.length; c++) {
      const change = (this.radiosity[c] - before[c]) * areas[Math.floor(c / 3)];
      sums[change < 0 ? 1 : 0] += Math.abs(change);
    }
    return sums;
  }

  // Returns the median over the shots of the largest |ΔB| of a channel: a lamp's may be a hundred times as large.
  typical_change() {
    const { trace, reflectance } = this;
    const largest = trace.links.map(({ scale, form_factors, shares }) => {
      const change = (k) => Math.max(...reflectance.subarray(3 * k, 3 * k + 3)) * scale * HALVES[form_factors[k]] * (shares ? Math.abs(HALVES[shares[k]]) : 1);
      return form_factors.reduce((most, _, k) => Math.max(most, change(k)), 0);
    });
    const of_shots = trace.shots.map((shot) => largest[shot.shooter] * Math.max(...shot.radiosity.map(Math.abs)));
    return of_shots.sort((a, b) => a - b)[Math.floor(of_shots.length / 2)];
  }

  // Returns r of texel `k` before the latest shot.
  residual_before(k) {
    return Array.from(this.before.residual.subarray(3 * k, 3 * k + 3));
  }
}
