// The links of a step of a solve to an error.

// Names of the gathers, in the order of the arrays.
const GATHERS = ["direct", "coarse", "final"];
const NO_TEXEL = 0xffffffff;

class LinkStep {
  // Reads the arrays of a step.
  static async read(element) {
    const step = Object.assign(new LinkStep(), JSON.parse(element.querySelector(".links-head").textContent));
    const arrays = await inflate(decode_bytes(element.querySelector(".links-data")));
    let at = 0;
    const take = (Kind, count) => { const own = new Kind(arrays.buffer, at, count); at += count * Kind.BYTES_PER_ELEMENT; return own; };
    // Rows of words, some of them floats.
    const rows = (count, width) => {
      const words = take(Uint32Array, count * width);
      const floats = new Float32Array(words.buffer, words.byteOffset, words.length);
      return Array.from({ length: count }, (_, k) => ({ word: (c) => words[width * k + c], floats: (c, n) => Array.from(floats.subarray(width * k + c, width * k + c + n)) }));
    };
    step.nodes = rows(step.nodes, 3).map(({ word }) => ({ parent: word(0), face: word(1), texel: word(2) === NO_TEXEL ? null : word(2), texels: 0 }));
    const corners = rows(step.inner, 12);
    let inner = 0;
    for (const node of step.nodes) {
      if (node.texel === null) node.corners = [0, 3, 6, 9].map((c) => corners[inner].floats(c, 3));
      inner += node.texel === null ? 1 : 0;
    }
    // A parent precedes its children.
    for (let k = step.nodes.length - 1; k >= 0; k--) {
      const node = step.nodes[k];
      if (node.texel !== null) node.texels = 1;
      if (node.parent !== k) step.nodes[node.parent].texels += node.texels;
    }
    step.leaf_of = [];
    step.nodes.forEach(({ texel }, k) => { if (texel !== null) step.leaf_of[texel] = k; });
    step.gathers = Object.fromEntries(step.gathers.map((head, k) => [GATHERS[k], read_gather(head, rows, take)]));
    return step;
  }

  // Returns the node that received the light of texel `k` in a gather, as the texel or as a part of it; none if nothing did.
  receiver(part, k) {
    const { spots_of } = this.gathers[part];
    let node = this.leaf_of[k];
    while (!spots_of.has(node) && this.nodes[node].parent !== node) node = this.nodes[node].parent;
    return spots_of.has(node) ? node : null;
  }

  // Returns w of link `k` to the block of a spot.
  weight(part, number, k) {
    const { spots, weights, scale } = this.gathers[part];
    const { block, lane } = spots[number];
    return scale * HALVES[weights[block.first_weight + block.spots * k + lane]];
  }

  // Returns the links to a receiver, the one of most light first: node, w and its mean radiosity. A texel on which a body stands
  // receives on its open parts, each with its share of the area.
  links_to(part, receiver) {
    const { spots_of, spots, links, radiosity } = this.gathers[part];
    const sums = new Map();
    for (const number of spots_of.get(receiver)) {
      const { block, share } = spots[number];
      for (let k = 0; k < block.links; k++) {
        const node = links[block.first_link + k];
        sums.set(node, (sums.get(node) ?? 0) + share * this.weight(part, number, k));
      }
    }
    const all = [...sums].filter(([, w]) => w > 0).map(([node, w]) => ({ node, w, radiosity: radiosity.get(node) }));
    const amount = (link) => link.w * (part === "coarse" ? 1 : luminance(link.radiosity));
    return all.map((link) => ({ ...link, amount: amount(link) })).sort((a, b) => b.amount - a.amount);
  }

  // Returns direct light and final gather of texel `k`, if it received both itself.
  light_of(k) {
    const leaf = this.leaf_of[k];
    const parts = ["direct", "final"].filter((part) => this.receiver(part, k) === leaf);
    return parts.length === 2 ? { direct: this.irradiance_of("direct", leaf), final: this.irradiance_of("final", leaf) } : null;
  }

  // Returns H of a receiver in a gather.
  irradiance_of(part, receiver) {
    const { spots_of, spots } = this.gathers[part];
    return spots_of.get(receiver).reduce((sum, number) => add(sum, spots[number].irradiance, spots[number].share), [0, 0, 0]);
  }
}

// Reads one gather.
function read_gather(head, rows, take) {
  const blocks = rows(head.blocks, 2).map(({ word }) => ({ spots: word(0), links: word(1) }));
  const spots = rows(head.spots, 5).map(({ word, floats }) => ({ node: word(0), share: floats(1, 1)[0], irradiance: floats(2, 3) }));
  const radiosity = new Map(rows(head.sources, 4).map(({ word, floats }) => [word(0), floats(1, 3)]));
  const links = take(Uint32Array, head.links);
  const low = take(Uint8Array, head.weights);
  const high = take(Uint8Array, head.weights);
  take(Uint8Array, (4 - ((2 * head.weights) % 4)) % 4);
  const weights = new Uint16Array(head.weights);
  const spots_of = new Map();
  let [spot, link, weight] = [0, 0, 0];
  for (const block of blocks) {
    Object.assign(block, { first_link: link, first_weight: weight });
    for (let lane = 0; lane < block.spots; lane++, spot++) {
      Object.assign(spots[spot], { block, lane });
      const { node } = spots[spot];
      spots_of.set(node, [...(spots_of.get(node) ?? []), spot]);
    }
    for (let k = 0; k < block.links; k++, link++) {
      for (let lane = 0; lane < block.spots; lane++, weight++) {
        weights[weight] = (lane > 0 ? weights[weight - 1] : 0) + unfold_difference(low[weight], high[weight]);
      }
    }
  }
  return { spots, radiosity, links, weights, spots_of, scale: 2 ** head.exponent };
}
