export { WebGLRenderer, Scene, PerspectiveCamera, Mesh, BufferGeometry, BufferAttribute, MeshLambertMaterial, DirectionalLight, HemisphereLight, Raycaster, Vector2, Vector3, Box3, Plane, DoubleSide, Matrix4 } from "three";
export { OrbitControls } from "three/addons/controls/OrbitControls.js";
