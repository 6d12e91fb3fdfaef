// The part of three.js (MIT) that the player uses; its own types would bring packages that nothing here needs.
declare module 'three' {
  type Numbers = Float32Array | Uint8Array;
  class Object3D { visible: boolean; matrixAutoUpdate: boolean; frustumCulled: boolean; castShadow: boolean; receiveShadow: boolean; renderOrder: number; matrix: Matrix4; position: Vector3; add(...children: Object3D[]): this; removeFromParent(): this; lookAt(x: number, y: number, z: number): void }
  class Vector3 { set(x: number, y: number, z: number): this }
  class Matrix4 { set(...n: number[]): this }
  class Color { constructor(colour: string); set(colour: string): this }
  class BufferAttribute { constructor(values: Numbers, size: number, normalized?: boolean); needsUpdate: boolean; setUsage(usage: number): this }
  class InstancedBufferAttribute extends BufferAttribute {}
  class BufferGeometry { setAttribute(name: string, values: BufferAttribute): this; setDrawRange(start: number, count: number): void; computeVertexNormals(): void; setIndex(indices: number[]): this; dispose(): void }
  class Material { dispose(): void; opacity: number; transparent: boolean; color: Color; needsUpdate: boolean }
  class MeshLambertMaterial extends Material { constructor(options: Record<string, unknown>) }
  class MeshBasicMaterial extends Material { constructor(options: Record<string, unknown>) }
  class ShadowMaterial extends Material { constructor(options: Record<string, unknown>) }
  class LineBasicMaterial extends Material { constructor(options: Record<string, unknown>) }
  class PointsMaterial extends Material { constructor(options: Record<string, unknown>); size: number }
  class Mesh extends Object3D { constructor(geometry: BufferGeometry, material: Material); material: Material }
  class InstancedMesh extends Mesh { constructor(geometry: BufferGeometry, material: Material, count: number); count: number; instanceMatrix: InstancedBufferAttribute & { array: Float32Array }; setColorAt(i: number, colour: Color): void; instanceColor: InstancedBufferAttribute | null }
  class LineSegments extends Object3D { constructor(geometry: BufferGeometry, material: Material); material: Material }
  class Points extends Object3D { constructor(geometry: BufferGeometry, material: Material); geometry: BufferGeometry; material: PointsMaterial }
  class HemisphereLight extends Object3D { constructor(sky: string, ground: string, intensity: number); intensity: number }
  class DirectionalLight extends Object3D { constructor(colour: string, intensity: number); target: Object3D; shadow: { mapSize: { set(x: number, y: number): void }; camera: { left: number; right: number; top: number; bottom: number; near: number; far: number }; bias: number; normalBias: number; radius: number } }
  class Fog { constructor(colour: string, near: number, far: number); color: Color }
  class Scene extends Object3D { fog: Fog }
  class PerspectiveCamera extends Object3D { constructor(field: number, aspect: number, near: number, far: number); aspect: number; up: Vector3; updateProjectionMatrix(): void }
  class WebGLRenderer { constructor(options: Record<string, unknown>); domElement: HTMLCanvasElement; shadowMap: { enabled: boolean; type: number }; setPixelRatio(ratio: number): void; setSize(width: number, height: number, style: boolean): void; render(scene: Scene, camera: PerspectiveCamera): void; setClearColor(colour: Color, opacity: number): void }
  const PCFSoftShadowMap: number;
  const DoubleSide: number;
  const DynamicDrawUsage: number;
}
