// A viewer that outlines texels and faces, and names them.

// Returns the lines around `places`.
const outline = (places, colour) => places.map((place, k) => [place, places[(k + 1) % places.length], colour]);

class OutlineViewer extends Viewer {
  // Returns corners, centroid and area of texel `k` in the mesh's unit.
  texel_outline(k) {
    const { positions, rings, corner_of } = this.shape;
    const nodes = rings[k].filter((_, r) => corner_of[k][r] >= 0);
    const corners = nodes.map((node) => Array.from(positions.subarray(3 * node, 3 * node + 3)));
    let [centre, area] = [[0, 0, 0], 0];
    for (let n = 1; n + 1 < corners.length; n++) {
      const triangle = [corners[0], corners[n], corners[n + 1]];
      const own = length(cross(sub(triangle[1], triangle[0]), sub(triangle[2], triangle[0]))) / 2;
      for (const corner of triangle) centre = add(centre, corner, own / 3);
      area += own;
    }
    return { corners, centre: area > 0 ? centre.map((x) => x / area) : corners[0], area };
  }

  face_corners(face) {
    return [0, 1, 2, 3].map((n) => this.scene.corners.subarray(12 * face + 3 * n, 12 * face + 3 * n + 3));
  }

  face_name(face) {
    return `face ${face} “${this.scene.names[this.scene.info[4 * face + 3]]}”`;
  }
}
