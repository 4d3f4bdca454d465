// SPDX-License-Identifier: Apache-2.0
// Parses protobuf without the service's code, like a team's software.

/** The fields of a protobuf message: field number to a list of numbers or byte strings. */
export function fieldsOf(bytes) {
  const fields = {};
  let at = 0;
  const varint = () => {
    let value = 0;
    for (let factor = 1; ; factor *= 128) {
      const byte = bytes[at++];
      value += (byte & 127) * factor;
      if (byte < 128) return value;
    }
  };
  while (at < bytes.length) {
    const tag = varint();
    const take = (length) => bytes.subarray(at, (at += length));
    const value = [varint, () => take(8), () => take(varint()), null, null, () => take(4)][tag & 7]();
    (fields[tag >> 3] ??= []).push(value);
  }
  return fields;
}

const float = (bytes) => bytes?.[0].readFloatLE(0);
const double = (bytes) => bytes?.[0].readDoubleLE(0);
const DETECTION = 1;
const GEOMETRY = 2;

function robot(bytes) {
  const f = fieldsOf(bytes);
  return { confidence: float(f[1]), robot_id: f[2]?.[0], x: float(f[3]), y: float(f[4]), orientation: float(f[5]), pixel_x: float(f[6]), pixel_y: float(f[7]), height: float(f[8]) };
}
function ball(bytes) {
  const f = fieldsOf(bytes);
  return { confidence: float(f[1]), area: f[2]?.[0], x: float(f[3]), y: float(f[4]), z: float(f[5]), pixel_x: float(f[6]), pixel_y: float(f[7]) };
}
const present = (object) => Object.fromEntries(Object.entries(object).filter(([, value]) => value !== undefined));

/** The detection of an SSL_WrapperPacket, with the names of the .proto file; null for other packets. */
export function detectionOf(packet) {
  const bytes = fieldsOf(packet)[DETECTION]?.[0];
  if (!bytes) return null;
  const f = fieldsOf(bytes);
  return present({
    frame_number: f[1][0], t_capture: double(f[2]), t_sent: double(f[3]), camera_id: f[4][0], balls: f[5]?.map((one) => present(ball(one))),
    robots_yellow: f[6]?.map((one) => present(robot(one))), robots_blue: f[7]?.map((one) => present(robot(one))), t_capture_camera: double(f[8]),
  });
}

/** Field size and element counts of an SSL_WrapperPacket's geometry; null for other packets. */
export function geometryOf(packet) {
  const bytes = fieldsOf(packet)[GEOMETRY]?.[0];
  if (!bytes) return null;
  const { 1: [fieldBytes], 2: calib = [] } = fieldsOf(bytes);
  const f = fieldsOf(fieldBytes);
  return { field_length: f[1][0], field_width: f[2][0], lines: f[6]?.length ?? 0, arcs: f[7]?.length ?? 0, cameras: calib.map((one) => fieldsOf(one)[1][0]) };
}
