// The arm in three dimensions: links as capsules, joints as drums along their axes, what the tool does and cannot do.

import {
  AmbientLight,
  AxesHelper,
  BufferAttribute,
  BufferGeometry,
  Color,
  CylinderGeometry,
  DirectionalLight,
  GridHelper,
  Group,
  Line,
  LineBasicMaterial,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  PerspectiveCamera,
  Plane,
  Raycaster,
  Scene,
  SphereGeometry,
  TorusGeometry,
  Vector2,
  Vector3,
  WebGLRenderer,
  ConeGeometry,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { stations } from "./kinematics.js";

const UP = new Vector3(0, 1, 0);
const TRAIL = 3000; // points
const SIDES = 24;
const BROKEN_SIDES = 5; // a joint that failed is seen by its shape, too

// Radius of a link for an arm of this length.
export function thickness(points) {
  let length = 0;
  for (let k = 1; k < points.length; ++k) length += Math.hypot(...points[k].map((x, r) => x - points[k - 1][r]));
  return 0.016 * (length > 1e-6 ? length : 1);
}

function lay(mesh, from, to, radius) {
  const a = new Vector3(...from), b = new Vector3(...to);
  const way = b.clone().sub(a), length = way.length();
  mesh.visible = length > 1e-9;
  if (!mesh.visible) return;
  mesh.position.copy(a).addScaledVector(way, 0.5);
  mesh.quaternion.setFromUnitVectors(UP, way.normalize());
  mesh.scale.set(radius, length, radius);
}

// Tubes and drums of one arm.
class Body {
  constructor(arm, width, opacity) {
    this.group = new Group();
    this.width = width;
    const material = () => new MeshLambertMaterial({ transparent: opacity < 1, opacity, depthWrite: opacity === 1 });
    const tube = new CylinderGeometry(1, 1, 1, 16), ball = new SphereGeometry(1, 16, 12);
    this.drum = new CylinderGeometry(1, 1, 1, SIDES);
    this.broken = new CylinderGeometry(1.25, 1.25, 1, BROKEN_SIDES);
    const add = (geometry, mesh = new Mesh(geometry, material())) => (this.group.add(mesh), mesh);
    this.links = [...arm.chain, null].map(() => add(tube));
    this.balls = [...arm.chain, null, null].map(() => add(ball));
    this.drums = opacity === 1 ? arm.chain.map(() => add(this.drum)) : [];
    this.arm = arm;
  }

  place(q, health, colours) {
    const { points, axes, tool } = stations(this.arm, q);
    this.points = points;
    const { width } = this;
    this.links.forEach((mesh, k) => lay(mesh, points[k], points[k + 1], width));
    this.balls.forEach((mesh, k) => {
      mesh.position.set(...points[k]);
      mesh.scale.setScalar(width);
    });
    for (const mesh of [...this.links, ...this.balls]) mesh.material.color.set(colours.link);
    this.drums.forEach((mesh, k) => {
      const state = health[this.arm.chain[k].joint];
      const at = points[k + 1], reach = 2.2 * width;
      const end = (sign) => at.map((x, r) => x + sign * reach * axes[k][r]);
      mesh.geometry = state ? this.broken : this.drum;
      lay(mesh, end(-1), end(1), 1.8 * width);
      mesh.material.color.set(state ? colours.health[state] : colours.joint);
    });
    return { points, tool };
  }
}

class Trail {
  constructor() {
    this.geometry = new BufferGeometry();
    this.geometry.setAttribute("position", new BufferAttribute(new Float32Array(3 * TRAIL), 3));
    this.line = new Line(this.geometry, new LineBasicMaterial());
    this.line.frustumCulled = false;
    this.clear();
  }

  clear() {
    this.count = 0;
    this.geometry.setDrawRange(0, 0);
  }

  add(x, y, z) {
    const { array } = this.geometry.attributes.position;
    if (this.count === TRAIL) {
      array.copyWithin(0, 3 * (TRAIL / 2));
      this.count = TRAIL / 2;
    }
    array.set([x, y, z], 3 * this.count++);
    this.geometry.setDrawRange(0, this.count);
    this.geometry.attributes.position.needsUpdate = true;
  }
}

// An arrow to either side, or a ring for a rotation.
class LostSign {
  constructor(size) {
    this.group = new Group();
    const material = (this.material = new MeshBasicMaterial());
    this.arrow = new Group();
    for (const sign of [-1, 1]) {
      const shaft = new Mesh(new CylinderGeometry(0.015, 0.015, 0.8, 8), material);
      const head = new Mesh(new ConeGeometry(0.05, 0.2, 12), material);
      shaft.position.y = 0.45 * sign;
      head.position.y = 0.9 * sign;
      head.rotation.z = sign < 0 ? Math.PI : 0;
      this.arrow.add(shaft, head);
    }
    this.ring = new Mesh(new TorusGeometry(0.6, 0.02, 8, 40), material);
    this.ring.rotation.x = Math.PI / 2;
    const spun = new Group();
    spun.add(this.ring);
    this.spun = spun;
    this.group.add(this.arrow, spun);
    this.group.scale.setScalar(size);
  }

  point(at, twist) {
    const v = new Vector3(...twist.slice(0, 3)), w = new Vector3(...twist.slice(3));
    this.arrow.visible = v.length() > 0.3;
    this.spun.visible = w.length() > 0.3;
    if (this.arrow.visible) this.arrow.quaternion.setFromUnitVectors(UP, v.normalize());
    if (this.spun.visible) this.spun.quaternion.setFromUnitVectors(UP, w.normalize());
    this.group.position.set(...at);
  }
}

export class Solid {
  constructor(canvas, arm, q) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    this.canvas = canvas;
    this.arm = arm;
    const { points } = stations(arm, q);
    const width = thickness(points);
    const size = Math.max(width / 0.016, 0.2);
    this.size = size;
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(38, 1, 0.01 * size, 50 * size);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.middle = new Vector3(...[0, 1, 2].map((r) => (Math.min(...points.map((p) => p[r])) + Math.max(...points.map((p) => p[r]))) / 2));
    this.view();
    this.sun = new DirectionalLight(0xffffff, 2.2);
    this.sun.position.set(1, -0.8, 2);
    this.scene.add(this.sun, new AmbientLight(0xffffff, 1.3));
    this.body = new Body(arm, width, 1);
    this.ghost = new Body(arm, 0.8 * width, 0.28);
    this.scene.add(this.body.group, this.ghost.group);
    this.targets = arm.chain.map(() => {
      const mesh = new Mesh(new SphereGeometry(3.4 * width, 12, 8), new MeshBasicMaterial({ visible: false }));
      this.scene.add(mesh);
      return mesh;
    });
    this.tool = new AxesHelper(0.09 * size);
    this.goal = new Mesh(new SphereGeometry(1.3 * width, 20, 14), new MeshBasicMaterial({ transparent: true, opacity: 0.75 }));
    this.goalAxes = new AxesHelper(0.06 * size);
    this.ellipsoid = new Mesh(new SphereGeometry(1, 24, 16), new MeshBasicMaterial({ wireframe: true, transparent: true, opacity: 0.25 }));
    this.ellipsoid.matrixAutoUpdate = false;
    this.lost = Array.from({ length: 6 }, () => new LostSign(0.22 * size));
    this.actual = new Trail();
    this.wanted = new Trail();
    this.scene.add(this.tool, this.goal, this.goalAxes, this.ellipsoid, this.actual.line, this.wanted.line, ...this.lost.map((sign) => sign.group));
    this.ray = new Raycaster();
  }

  view() {
    this.controls.target.copy(this.middle);
    this.camera.position.copy(this.middle).add(new Vector3(1.25, -1.35, 0.75).multiplyScalar(this.size));
    this.controls.update();
  }

  theme(colours) {
    this.colours = colours;
    this.scene.background = new Color(colours.paper);
    if (this.grid) {
      this.scene.remove(this.grid);
      this.grid.geometry.dispose();
      this.grid.material.dispose();
    }
    this.grid = new GridHelper(3 * this.size, 24, colours.grid, colours.grid);
    this.grid.rotation.x = Math.PI / 2;
    this.scene.add(this.grid);
    this.actual.line.material.color.set(colours.actual);
    this.wanted.line.material.color.set(colours.target);
    this.goal.material.color.set(colours.target);
    this.ellipsoid.material.color.set(colours.joint);
    for (const sign of this.lost) sign.material.color.set(colours.bad);
  }

  resize(width, height, ratio) {
    this.renderer.setPixelRatio(Math.min(ratio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
  }

  // found: a snapshot, or a moment of a run; shown: what the reader wants to see.
  draw(found, shown) {
    const { points, tool } = this.body.place(found.q, found.health, this.colours);
    this.targets.forEach((mesh, k) => mesh.position.set(...points[k + 1]));
    this.ghost.group.visible = shown.ghost && !!found.ghost;
    if (this.ghost.group.visible) this.ghost.place(found.ghost, found.health, { ...this.colours, link: this.colours.ghost });
    this.tool.matrixAutoUpdate = false;
    this.tool.matrix.set(...tool);
    const { target } = found;
    this.goal.position.set(target[3], target[7], target[11]);
    this.goalAxes.matrixAutoUpdate = false;
    this.goalAxes.matrix.set(...target);
    const at = [tool[3], tool[7], tool[11]];
    this.ellipsoid.visible = shown.ellipsoid && !!found.sigma && found.sigma[0] > 0;
    if (this.ellipsoid.visible) {
      const scale = (0.16 * this.size) / found.sigma[0];
      const axes = [0, 1, 2].map((k) => new Vector3(...found.axis.slice(3 * k, 3 * k + 3)).multiplyScalar(Math.max(scale * found.sigma[k], 1e-4)));
      this.ellipsoid.matrix.makeBasis(...axes).setPosition(...at);
    }
    this.lost.forEach((sign, k) => {
      sign.group.visible = shown.lost && k < found.signs.length;
      if (sign.group.visible) sign.point(at, found.signs[k]);
    });
    this.actual.line.visible = this.wanted.line.visible = shown.trail;
    for (let k = 0; k + 5 < (found.trail?.length ?? 0); k += 6) {
      this.actual.add(...found.trail.subarray(k, k + 3));
      this.wanted.add(...found.trail.subarray(k + 3, k + 6));
    }
    this.controls.update();
    this.renderer.render(this.scene, this.camera);
  }

  clear() {
    this.actual.clear();
    this.wanted.clear();
  }

  // Where a point [m] is on the canvas, in its own pixels.
  project(point) {
    const p = new Vector3(...point).project(this.camera);
    return [((p.x + 1) / 2) * this.canvas.clientWidth, ((1 - p.y) / 2) * this.canvas.clientHeight, p.z < 1];
  }

  station(link) {
    return this.body.points[link + 1];
  }

  // Points on the drums of a joint, from their ends on.
  handles(joint) {
    const points = [];
    this.arm.chain.forEach((link, k) => {
      if (link.joint !== joint) return;
      for (const share of [0.45, -0.45, 0.3, -0.3, 0])
        for (const [x, z] of [[0, 0], [0.9, 0], [-0.9, 0], [0, 0.9], [0, -0.9]])
          points.push(new Vector3(x, share, z).applyMatrix4(this.body.drums[k].matrixWorld).toArray());
    });
    return points;
  }

  aim(x, y) {
    this.ray.setFromCamera(new Vector2((2 * x) / this.canvas.clientWidth - 1, 1 - (2 * y) / this.canvas.clientHeight), this.camera);
  }

  // The joint at a pixel, or -1; "goal" for the target. What one sees there counts first, then what is near.
  pick(x, y) {
    this.aim(x, y);
    const { drums } = this.body;
    const seen = this.ray.intersectObjects([...drums.filter((drum) => drum.visible), this.goal])[0];
    if (seen) return seen.object === this.goal ? "goal" : this.arm.chain[drums.indexOf(seen.object)].joint;
    const near = this.ray.intersectObjects([...this.targets, this.goal]).sort((a, b) => this.away(a, x, y) - this.away(b, x, y))[0];
    if (!near) return -1;
    return near.object === this.goal ? "goal" : this.arm.chain[this.targets.indexOf(near.object)].joint;
  }

  away(hit, x, y) {
    const [u, v] = this.project(hit.object.position.toArray());
    return Math.hypot(u - x, v - y);
  }

  // The point below a pixel, in the plane of the screen through another.
  under(x, y, through) {
    this.aim(x, y);
    const normal = this.camera.getWorldDirection(new Vector3());
    const found = this.ray.ray.intersectPlane(new Plane().setFromNormalAndCoplanarPoint(normal, new Vector3(...through)), new Vector3());
    return found ? found.toArray() : null;
  }

  // The screen's right and up, in base axes.
  plane() {
    const x = new Vector3(), y = new Vector3(), z = new Vector3();
    this.camera.matrixWorld.extractBasis(x, y, z);
    return [x.toArray(), y.toArray()];
  }

  orbit(on) {
    this.controls.enabled = on;
  }
}

