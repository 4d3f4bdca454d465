// SPDX-License-Identifier: Apache-2.0
// Line icons on a 24 px grid, each one path.

const circle = (x: number, y: number, r: number) => `M${x - r} ${y}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0`;

export const icons = {
  activity: 'M3 12h4l3-8 4 16 3-8h4',
  ball: circle(12, 12, 5),
  camera: `M4 8.5A1.5 1.5 0 0 1 5.5 7H8l1.5-2.5h5L16 7h2.5A1.5 1.5 0 0 1 20 8.5v9a1.5 1.5 0 0 1-1.5 1.5h-13A1.5 1.5 0 0 1 4 17.5z${circle(12, 13, 3.4)}`,
  check: 'M5 12.5l4.5 4.5L19 7.5',
  chevron: 'M6 9l6 6 6-6',
  copy: 'M9 8.5h9.5a1.5 1.5 0 0 1 1.5 1.5v9.5a1.5 1.5 0 0 1-1.5 1.5H9a1.5 1.5 0 0 1-1.5-1.5V10A1.5 1.5 0 0 1 9 8.5zM16.5 8.5V5A1.5 1.5 0 0 0 15 3.5H5.5A1.5 1.5 0 0 0 4 5v9.5A1.5 1.5 0 0 0 5.5 16h2',
  cross: 'M6 6l12 12M18 6L6 18',
  download: 'M12 4v11M7 10.5l5 5 5-5M5 20h14',
  expand: 'M9 4H4v5M15 4h5v5M9 20H4v-5M15 20h5v-5',
  history: 'M4 12a8 8 0 1 0 2.5-5.8L4 8.5M4 4v4.5h4.5M12 8v4.5l3 2',
  hide: 'M4 4l16 16M9.5 6a9 9 0 0 1 2.5-.4c6 0 9.5 6.4 9.5 6.4a17 17 0 0 1-2.7 3.4M6.3 7.8A16 16 0 0 0 2.5 12S6 18.5 12 18.5c1.5 0 2.9-.4 4.1-1',
  info: `${circle(12, 12, 9)}M12 11v5.5M12 7.6v.1`,
  link: 'M10 14a4 4 0 0 0 6 0l3-3a4 4 0 0 0-6-6l-1 1M14 10a4 4 0 0 0-6 0l-3 3a4 4 0 0 0 6 6l1-1',
  minus: 'M5 12h14',
  more: `${circle(5.5, 12, 1)}${circle(12, 12, 1)}${circle(18.5, 12, 1)}`,
  moon: 'M19.5 14.5A8 8 0 0 1 9.5 4.5a8 8 0 1 0 10 10z',
  network: `${circle(12, 5, 2.2)}${circle(5.5, 18, 2.2)}${circle(18.5, 18, 2.2)}M12 7.2V12M12 12l-5.2 4.2M12 12l5.2 4.2`,
  nocamera: 'M4 4l16 16M8 7H5.5A1.5 1.5 0 0 0 4 8.5v9A1.5 1.5 0 0 0 5.5 19H18M9.3 5l.2-.5h5L16 7h2.5A1.5 1.5 0 0 1 20 8.5v8M9.6 10.6a3.4 3.4 0 0 0 4.8 4.8',
  overview: 'M5 4h14a2 2 0 0 1 2 2v12a2 2 0 0 1-2 2H5a2 2 0 0 1-2-2V6a2 2 0 0 1 2-2zM12 4v16M3 9.5h3v5H3M21 9.5h-3v5h3',
  pause: 'M9 6v12M15 6v12',
  play: 'M8 5.5v13l10.5-6.5z',
  plus: 'M12 5v14M5 12h14',
  polygon: 'M5 8l8-4 6 7-4 8-9-2z',
  robot: 'M6.5 18.5a8.5 8.5 0 1 1 11 0zM12 5v4',
  search: `${circle(11, 11, 6.5)}M16 16l4.5 4.5`,
  sliders: `M4 7h9M17 7h3M4 12h3M11 12h9M4 17h7M15 17h5${circle(15, 7, 2)}${circle(9, 12, 2)}${circle(13, 17, 2)}`,
  sun: `${circle(12, 12, 4)}M12 2.5v2M12 19.5v2M2.5 12h2M19.5 12h2M5.3 5.3l1.4 1.4M17.3 17.3l1.4 1.4M5.3 18.7l1.4-1.4M17.3 6.7l1.4-1.4`,
  target: `${circle(12, 12, 7)}M12 2.5v5M12 16.5v5M2.5 12h5M16.5 12h5`,
  trash: 'M5 7h14M10 7V4.5h4V7M7 7l.8 12.5h8.4L17 7M10.5 10.5v6M13.5 10.5v6',
  turn: 'M20 12a8 8 0 1 1-2.5-5.8L20 8.5M20 4v4.5h-4.5',
  undo: 'M9 5L4.5 9.5L9 14M4.5 9.5H14a5.5 5.5 0 0 1 0 11h-3',
  unplugged: 'M4 4l16 16M2.5 9.5A14 14 0 0 1 7 6.7M11 5.6a14 14 0 0 1 10.5 3.9M5.8 13a9 9 0 0 1 4-2.2M15 11.3a9 9 0 0 1 3.2 1.7M9.3 16.3a4.2 4.2 0 0 1 5.4 0M12 19.5v.1',
  upload: 'M12 16V5M7 9.5l5-5 5 5M5 20h14',
  warn: 'M12 4L2.8 19.5h18.4zM12 10v4.5M12 17.2v.1',
} as const;

export type IconName = keyof typeof icons;
