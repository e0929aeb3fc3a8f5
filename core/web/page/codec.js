// Tells why the browser cannot play a video file: finds its codec or file type in the file's first or last bytes.

// Number of bytes at a file's start and end that are searched for its codecs, which phones list at the end.
const HEAD = 1 << 20, TAIL = 8 << 20;

const HEVC = ["HEVC (H.265)", 'video/mp4; codecs="hvc1.1.6.L93.B0"'];
const AVC = ["H.264", 'video/mp4; codecs="avc1.640028"'];
const AV1 = ["AV1", 'video/mp4; codecs="av01.0.04M.08"'];
const VP9 = ["VP9", 'video/webm; codecs="vp9"'];
const MPEG4 = ["MPEG-4 Visual", 'video/mp4; codecs="mp4v.20.9"'];
const PRORES = ["ProRes", 'video/mp4; codecs="apcn"'];
const CODECS = {
  hvc1: HEVC, hev1: HEVC, dvh1: HEVC, dvhe: HEVC, "V_MPEGH/ISO/HEVC": HEVC, avc1: AVC, avc3: AVC, "V_MPEG4/ISO/AVC": AVC, av01: AV1, V_AV1: AV1,
  vp09: VP9, V_VP9: VP9, V_VP8: ["VP8", 'video/webm; codecs="vp8"'], mp4v: MPEG4, "V_MPEG4/ISO/ASP": MPEG4, "V_MS/VFW/FOURCC": ["AVI in Matroska", ""],
  apch: PRORES, apcn: PRORES, apcs: PRORES, apco: PRORES, ap4h: PRORES, V_PRORES: PRORES,
};
// File types that browsers do not play, by their first bytes.
const KINDS = [[/^RIFF....AVI /s, "AVI"], [/^\x30\x26\xb2\x75/, "WMV"], [/^FLV/, "FLV"], [/^G.{187}G/s, "MPEG-TS"], [/^YUV4MPEG2/, "Y4M"]];

/** Returns the name of the codec or file type that this browser cannot play; null if none is found. */
export async function lacking(file, video) {
  const read = async (part) => new TextDecoder("latin1").decode(await part.arrayBuffer());
  const head = await read(file.slice(0, HEAD));
  const kind = KINDS.find(([start]) => start.test(head));
  if (kind !== undefined) {
    return kind[1];
  }
  const found = codecOf(head) ?? codecOf(await read(file.slice(-TAIL)));
  const [name, type] = CODECS[found] ?? [];
  return name !== undefined && video.canPlayType(type) === "" ? name : null;
}

// In MP4 a codec's name is 16 bytes after the start of `stsd`. Audio codecs are skipped, as `CODECS` lacks them.
function codecOf(bytes) {
  const all = [...bytes.matchAll(/stsd.{12}(.{4})/gs), ...bytes.matchAll(/(V_[A-Z0-9/_]+)/g)];
  return all.map(([, name]) => name).find((name) => CODECS[name] !== undefined);
}
