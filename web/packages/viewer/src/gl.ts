// SPDX-License-Identifier: MIT
// WebGL2, with a little less typing: programs with their uniforms, textures, buffers.

export type GL = WebGL2RenderingContext;

export interface Program {
  readonly program: WebGLProgram;
  readonly uniforms: Record<string, WebGLUniformLocation>;
}

/** Where attributes are bound, in every program. */
export const ATTRIBUTES = [
  "position", "light", "behind", "coordinates0", "coordinates1", "normal",
  "direct0", "direct1", "direct2", "directBehind0", "directBehind1", "directBehind2",
] as const;

export function compiled(gl: GL, vertex: string, fragment: string): Program {
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]] as const) {
    const shader = gl.createShader(kind);
    if (!shader) throw new Error("The browser has lost its graphics.");
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader) ?? "");
    gl.attachShader(program, shader);
  }
  ATTRIBUTES.forEach((name, index) => gl.bindAttribLocation(program, index, name));
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program) ?? "");
  const uniforms: Record<string, WebGLUniformLocation> = {};
  for (let k = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS) as number; k--; ) {
    const name = gl.getActiveUniform(program, k)!.name.replace("[0]", "");
    uniforms[name] = gl.getUniformLocation(program, name)!;
  }
  return { program, uniforms };
}

export function buffer(gl: GL, target: number, data: AllowSharedBufferSource): WebGLBuffer {
  const made = gl.createBuffer();
  gl.bindBuffer(target, made);
  gl.bufferData(target, data, gl.STATIC_DRAW);
  return made;
}

/** A texture bound to its target, with no smoothing and no repeating. */
export function texture(gl: GL, target: number): WebGLTexture {
  const made = gl.createTexture();
  gl.bindTexture(target, made);
  for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T, gl.TEXTURE_WRAP_R]) gl.texParameteri(target, side, gl.CLAMP_TO_EDGE);
  for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(target, filter, gl.NEAREST);
  return made;
}

export function smooth(gl: GL, target: number): void {
  for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(target, filter, gl.LINEAR);
}

/** Binds a texture to a unit, and a sampler of the program in use to that. */
export function bindTexture(gl: GL, unit: number, bound: WebGLTexture | null, { uniforms }: Program, name: string): void {
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.bindTexture(gl.TEXTURE_2D, bound);
  gl.uniform1i(uniforms[name]!, unit);
}
