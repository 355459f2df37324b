// What drawing needs of a mesh: vertices split at sharp edges, the edges, and normals.

const SHARP = Math.cos((40 * Math.PI) / 180); // edges that bend by more than 40 degrees are drawn as edges

export type Numbers = Float32Array | Float64Array;

// Normals of the triangles, of length 1.
function computeTriangleNormals(x: Numbers, corners: Uint32Array): Float32Array {
  const normals = new Float32Array(corners.length);
  for (let t = 0; t < corners.length; t += 3) {
    const a = 3 * corners[t],
      b = 3 * corners[t + 1],
      c = 3 * corners[t + 2];
    const ux = x[b] - x[a],
      uy = x[b + 1] - x[a + 1],
      uz = x[b + 2] - x[a + 2];
    const vx = x[c] - x[a],
      vy = x[c + 1] - x[a + 1],
      vz = x[c + 2] - x[a + 2];
    const nx = uy * vz - uz * vy,
      ny = uz * vx - ux * vz,
      nz = ux * vy - uy * vx,
      length = Math.hypot(nx, ny, nz) || 1;
    normals.set([nx / length, ny / length, nz / length], t);
  }
  return normals;
}

// For each corner of a triangle the drawn vertex, and for each drawn vertex the mesh's vertex. Corners of a vertex are one
// drawn vertex where a chain of triangles leads from one to the other over edges that are not sharp.
export function splitSharpEdges(x: Numbers, corners: Uint32Array): { index: Uint32Array; source: Uint32Array } {
  const normals = computeTriangleNormals(x, corners),
    vertexCount = x.length / 3;
  const parent = Uint32Array.from({ length: corners.length }, (_, i) => i);
  const find = (start: number) => {
    let i = start;
    while (parent[i] !== i) i = parent[i] = parent[parent[i]];
    return i;
  };
  const first = new Map<number, number>(); // edge -> the corner at which it begins in the first triangle that has it
  for (let i = 0; i < corners.length; i++) {
    const next = i % 3 === 2 ? i - 2 : i + 1;
    const edge = Math.min(corners[i], corners[next]) * vertexCount + Math.max(corners[i], corners[next]);
    const other = first.get(edge);
    if (other === undefined) {
      first.set(edge, i);
      continue;
    }
    const otherNext = other % 3 === 2 ? other - 2 : other + 1,
      t = 3 * Math.floor(i / 3),
      u = 3 * Math.floor(other / 3);
    if (normals[t] * normals[u] + normals[t + 1] * normals[u + 1] + normals[t + 2] * normals[u + 2] < SHARP) continue;
    const isOpposite = corners[i] === corners[otherNext];
    parent[find(i)] = find(isOpposite ? otherNext : other);
    parent[find(next)] = find(isOpposite ? other : otherNext);
  }
  const number = new Map<number, number>(),
    source: number[] = [];
  const index = corners.map((vertex, i) => {
    const root = find(i);
    if (!number.has(root)) number.set(root, source.push(vertex) - 1);
    return number.get(root)!;
  });
  return { index, source: Uint32Array.from(source) };
}

// The two vertices of every edge.
export function findEdges(index: Uint32Array, vertexCount: number): Uint32Array {
  const seen = new Set<number>(),
    edges = new Uint32Array(2 * index.length);
  let length = 0;
  for (let i = 0; i < index.length; i++) {
    const next = i % 3 === 2 ? i - 2 : i + 1;
    const low = Math.min(index[i], index[next]),
      high = Math.max(index[i], index[next]),
      key = low * vertexCount + high;
    if (seen.has(key)) continue;
    seen.add(key);
    edges[length++] = low;
    edges[length++] = high;
  }
  return edges.slice(0, length);
}

// Normals of vertices, into `n`: means of the triangles around, weighted by their areas.
export function computeNormals(x: Numbers, index: Uint32Array, n: Float32Array): void {
  n.fill(0);
  for (let i = 0; i < index.length; i += 3) {
    const a = 3 * index[i],
      b = 3 * index[i + 1],
      c = 3 * index[i + 2];
    const ux = x[b] - x[a],
      uy = x[b + 1] - x[a + 1],
      uz = x[b + 2] - x[a + 2];
    const vx = x[c] - x[a],
      vy = x[c + 1] - x[a + 1],
      vz = x[c + 2] - x[a + 2];
    const nx = uy * vz - uz * vy,
      ny = uz * vx - ux * vz,
      nz = ux * vy - uy * vx;
    n[a] += nx;
    n[a + 1] += ny;
    n[a + 2] += nz;
    n[b] += nx;
    n[b + 1] += ny;
    n[b + 2] += nz;
    n[c] += nx;
    n[c + 1] += ny;
    n[c + 2] += nz;
  }
  for (let i = 0; i < n.length; i += 3) {
    const length = Math.sqrt(n[i] * n[i] + n[i + 1] * n[i + 1] + n[i + 2] * n[i + 2]) || 1;
    n[i] /= length;
    n[i + 1] /= length;
    n[i + 2] /= length;
  }
}
