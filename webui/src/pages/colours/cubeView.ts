// SPDX-License-Identifier: Apache-2.0
// Renders the table in the YUV cube: U to the right, V to the back, Y up. Drawn on changes only.
import {
  AmbientLight, BoxGeometry, BufferGeometry, Color, DirectionalLight, DoubleSide, Float32BufferAttribute, InstancedMesh, LineBasicMaterial, LineSegments,
  Matrix4, Mesh, MeshBasicMaterial, MeshLambertMaterial, PerspectiveCamera, PlaneGeometry, Scene, Vector3, WebGLRenderer,
} from 'three';
import type { Cube } from './table';

export interface CubeStyle {
  line: string;
  plane: string;
}

/** Positions of the axis names, as shares of the view. */
export type AxisPlaces = Record<'Y' | 'U' | 'V', { left: number; top: number }>;

const START = { yaw: 0.62, pitch: 0.42, distance: 3.3 };
const CLOSEST = 1.7;
const FARTHEST = 6;
const STEEPEST = 1.45;
/** Black on a dark ground shows no shape, so it is drawn lighter. */
const DARKEST = 0.16;

/** Null if the browser has no WebGL. */
export function createCubeView(canvas: HTMLCanvasElement, style: CubeStyle, onAxes: (places: AxisPlaces) => void) {
  // The context is created here, because three.js would log a missing WebGL to the console.
  const context = canvas.getContext('webgl2', { antialias: true, alpha: true, powerPreference: 'low-power' });
  if (!context) return null;
  const renderer = new WebGLRenderer({ canvas, context, alpha: true, antialias: true });
  const scene = new Scene();
  const camera = new PerspectiveCamera(32, 1, 0.1, 20);
  scene.add(new AmbientLight(0xffffff, 1.5));
  const sun = new DirectionalLight(0xffffff, 2.2);
  scene.add(sun);

  const edges = new BufferGeometry();
  const corners = [-0.5, 0.5];
  const points: number[] = [];
  for (const a of corners) {
    for (const b of corners) points.push(-0.5, a, b, 0.5, a, b, a, -0.5, b, a, 0.5, b, a, b, -0.5, a, b, 0.5);
  }
  edges.setAttribute('position', new Float32BufferAttribute(points, 3));
  const frameMaterial = new LineBasicMaterial({ color: style.line });
  scene.add(new LineSegments(edges, frameMaterial));

  const planeGeometry = new PlaneGeometry(1, 1);
  const planeMaterial = new MeshBasicMaterial({ color: style.plane, transparent: true, opacity: 0.16, side: DoubleSide, depthWrite: false });
  const plane = new Mesh(planeGeometry, planeMaterial);
  plane.rotation.x = -Math.PI / 2;
  const rim = new BufferGeometry();
  rim.setAttribute('position', new Float32BufferAttribute([-0.5, 0, -0.5, 0.5, 0, -0.5, 0.5, 0, -0.5, 0.5, 0, 0.5, 0.5, 0, 0.5, -0.5, 0, 0.5, -0.5, 0, 0.5, -0.5, 0, -0.5], 3));
  const rimMaterial = new LineBasicMaterial({ color: style.plane });
  const rimLines = new LineSegments(rim, rimMaterial);
  scene.add(plane, rimLines);

  const box = new BoxGeometry(1, 1, 1);
  const material = new MeshLambertMaterial();
  let mesh: InstancedMesh | null = null;
  const angle = { ...START };
  let asked = 0;

  function render(): void {
    asked = 0;
    const { yaw, pitch, distance } = angle;
    camera.position.set(distance * Math.sin(yaw) * Math.cos(pitch), distance * Math.sin(pitch), distance * Math.cos(yaw) * Math.cos(pitch));
    camera.lookAt(0, -0.04, 0);
    sun.position.copy(camera.position).add(new Vector3(-1, 2, 0.5));
    renderer.render(scene, camera);
    const place = (x: number, y: number, z: number) => {
      const at = new Vector3(x, y, z).project(camera);
      return { left: (at.x + 1) / 2, top: (1 - at.y) / 2 };
    };
    onAxes({ Y: place(-0.56, 0.5, 0.56), U: place(0.2, -0.58, 0.6), V: place(0.6, -0.58, -0.1) });
  }
  const draw = () => { asked ||= requestAnimationFrame(render); };

  function clear(): void {
    if (!mesh) return;
    scene.remove(mesh);
    mesh.dispose();
    mesh = null;
  }

  return {
    /** `colours`: "#rrggbb" of each label. Cells for which `bright` is true are white, and all others dim. */
    show(cube: Cube, colours: ReadonlyMap<number, string>, bright: ((y: number, u: number, v: number) => boolean) | null): void {
      clear();
      if (cube.count) {
        mesh = new InstancedMesh(box, material, cube.count);
        const size = 1 / cube.side;
        const matrix = new Matrix4().makeScale(size, size, size);
        const tones = new Map([...colours].map(([label, css]) => {
          const color = new Color(css);
          const lift = Math.max(color.r, color.g, color.b) < 0.02 ? DARKEST / 2 : 0;
          return [label, lift ? color.setRGB(lift, lift, lift * 1.15) : color] as const;
        }));
        const white = new Color('#ffffff');
        const shade = new Color();
        for (let i = 0; i < cube.count; i++) {
          const [y, u, v] = [cube.at[3 * i]!, cube.at[3 * i + 1]!, cube.at[3 * i + 2]!];
          matrix.setPosition((u + 0.5) * size - 0.5, (y + 0.5) * size - 0.5, 0.5 - (v + 0.5) * size);
          mesh.setMatrixAt(i, matrix);
          shade.copy(tones.get(cube.labels[i]!) ?? white);
          if (bright) { if (bright(y, u, v)) shade.copy(white); else shade.multiplyScalar(0.25); }
          mesh.setColorAt(i, shade);
        }
        scene.add(mesh);
      }
      draw();
    },
    slice(share: number): void {
      plane.position.y = share - 0.5;
      rimLines.position.y = share - 0.5;
      draw();
    },
    style(next: CubeStyle): void {
      frameMaterial.color.set(next.line);
      planeMaterial.color.set(next.plane);
      rimMaterial.color.set(next.plane);
      draw();
    },
    resize(width: number, height: number): void {
      if (!width || !height) return;
      renderer.setPixelRatio(Math.min(2, devicePixelRatio));
      renderer.setSize(width, height, false);
      camera.aspect = width / height;
      camera.updateProjectionMatrix();
      draw();
    },
    turn(dx: number, dy: number): void {
      angle.yaw -= dx * 0.008;
      angle.pitch = Math.min(STEEPEST, Math.max(-STEEPEST, angle.pitch + dy * 0.008));
      draw();
    },
    zoom(factor: number): void {
      angle.distance = Math.min(FARTHEST, Math.max(CLOSEST, angle.distance / factor));
      draw();
    },
    reset(): void {
      Object.assign(angle, START);
      draw();
    },
    dispose(): void {
      cancelAnimationFrame(asked);
      clear();
      for (const one of [edges, planeGeometry, rim, box]) one.dispose();
      for (const one of [frameMaterial, planeMaterial, rimMaterial, material]) one.dispose();
      renderer.dispose();
      renderer.forceContextLoss();
    },
  };
}
export type CubeView = NonNullable<ReturnType<typeof createCubeView>>;
