// Viewer of a step: the node that received the light of the texel that is pointed at, and its links as lines from the nodes
// that sent it.

const LINK_COLOUR = [0.35, 0.85, 1];
const RECEIVER_COLOUR = [1, 0.55, 0.1, 1];
const POINTED_COLOUR = [1, 1, 0.35, 1];
// Least opacity of a link.
const MIN_OPACITY = 0.07;

class LinkViewer extends OutlineViewer {
  // Shows the links of `step`; `looked` is called when another texel is pointed at.
  attach(step, looked) {
    this.step = step;
    this.looked = looked;
    this.part = "direct";
  }

  keys() {
    // Left and right move through the steps.
    const { ArrowLeft, ArrowRight, ...others } = super.keys();
    return others;
  }

  look(x, y) {
    super.look(x, y);
    this.point_at(this.seen);
  }

  // Points at texel `k`, or at none.
  point_at(k) {
    this.seen = k;
    if (!this.step) return;
    this.receiver = k === null ? null : this.step.receiver(this.part, k);
    this.received = this.receiver === null ? [] : this.step.links_to(this.part, this.receiver);
    this.pointed = null;
    this.mark();
    this.looked();
  }

  select_part(part) {
    this.part = part;
    this.point_at(this.seen);
  }

  // Outlines one of the nodes that sent light; null outlines none.
  outline_node(node) {
    this.pointed = node;
    this.mark();
  }

  // Returns the corners of a node; a triangle’s last two are one.
  node_corners(k) {
    const { texel, corners } = this.step.nodes[k];
    return texel === null ? corners : this.texel_outline(texel).corners;
  }

  node_centre(k) {
    const corners = this.node_corners(k);
    const apart = corners.filter((corner, n) => n === 0 || length(sub(corner, corners[n - 1])) > 0);
    return apart.reduce((sum, corner) => add(sum, corner, 1 / apart.length), [0, 0, 0]);
  }

  // Returns the name of a node.
  node_name(k) {
    const { face, texels } = this.step.nodes[k];
    return `${this.face_name(face)}, ${texels === 1 ? "one texel" : `node of ${texels} texels`}`;
  }

  short_node_name(k) {
    const { face, texels } = this.step.nodes[k];
    return `${this.scene.names[this.scene.info[4 * face + 3]]} (${face}), ${texels === 1 ? "1 texel" : `${texels} texels`}`;
  }

  // Draws the receiver and its links: the more light, the more opaque.
  mark() {
    const lines = [];
    if (this.receiver !== null && this.receiver !== undefined) {
      const to = this.node_centre(this.receiver);
      const most = this.received.length > 0 ? this.received[0].amount : 0;
      for (const { node, amount } of this.received) {
        const tint = [...LINK_COLOUR, Math.max(MIN_OPACITY, Math.sqrt(share_of(amount, most)))];
        lines.push(...outline(this.node_corners(node), tint), [this.node_centre(node), to, tint]);
      }
      lines.push(...outline(this.node_corners(this.receiver), RECEIVER_COLOUR));
    }
    if (this.seen !== null) lines.push(...outline(this.texel_outline(this.seen).corners, RECEIVER_COLOUR));
    if (this.pointed !== null && this.pointed !== undefined) {
      lines.push(...outline(this.node_corners(this.pointed), POINTED_COLOUR));
    }
    this.lines.set(this.gl, lines.filter(([from, to]) => length(sub(from, to)) > 0));
    this.ask();
  }
}
