// Pictures with their full range: of each pixel mantissas of 8 bits of red, green and blue, and their common exponent plus 128.
// byteAt(pixel, 0 to 3) tells them.
function decodeFullRange(width, height, byteAt) {
  const rgb = new Float32Array(3 * width * height);
  for (let i = 0; i < width * height; ++i) {
    const exponent = byteAt(i, 3), scale = 2 ** (exponent - 128 - 8);
    if (exponent === 0) continue;
    for (let c = 0; c < 3; ++c) rgb[3 * i + c] = byteAt(i, c) === 0 ? 0 : (byteAt(i, c) + 0.5) * scale;
  }
  return { width, height, rgb };
}

// Of an image of twice the height, mantissas above, the exponent below.
function decodePicture(image) {
  const width = image.naturalWidth, height = image.naturalHeight / 2, count = width * height;
  const canvas = element("canvas", { width, height: 2 * height });
  const context = canvas.getContext("2d", { willReadFrequently: true, colorSpace: "srgb" });
  context.drawImage(image, 0, 0);
  const bytes = context.getImageData(0, 0, width, 2 * height).data;
  return decodeFullRange(width, height, (i, k) => k < 3 ? bytes[4 * i + k] : bytes[4 * (i + count)]);
}

// As the PNGs of `render` are made: the shoulder of Khronos' PBR Neutral tone mapper, then the sRGB curve.
const START = 0.8, DESATURATION = 0.15;
const SRGB = Uint8ClampedArray.from({ length: 4097 }, (_, i) => {
  const v = i / 4096;
  return Math.round(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));
});
function drawPicture(canvas, picture, exposure) {
  const { width, height, rgb } = picture, scale = 2 ** exposure;
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  const context = canvas.getContext("2d"), shown = context.createImageData(width, height);
  for (let i = 0; i < width * height; ++i) {
    const color = [scale * rgb[3 * i], scale * rgb[3 * i + 1], scale * rgb[3 * i + 2]], peak = Math.max(...color);
    let newPeak = peak, keep = 1;
    if (peak >= START) {
      newPeak = 1 - (1 - START) ** 2 / (peak + 1 - 2 * START);
      keep = 1 / (DESATURATION * (peak - newPeak) + 1);
    }
    for (let c = 0; c < 3; ++c) {
      const v = peak < START ? color[c] : newPeak + keep * (color[c] * newPeak / peak - newPeak);
      shown.data[4 * i + c] = SRGB[Math.max(0, Math.round(4096 * v))];
    }
    shown.data[4 * i + 3] = 255;
  }
  context.putImageData(shown, 0, 0);
}
