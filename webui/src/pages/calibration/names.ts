// SPDX-License-Identifier: Apache-2.0
// Display names of the league's lines and points.

const LINES: Record<string, string> = {
  TopTouchLine: 'Touch line +y',
  BottomTouchLine: 'Touch line −y',
  LeftGoalLine: 'Goal line −x',
  RightGoalLine: 'Goal line +x',
  HalfwayLine: 'Halfway line',
  CenterLine: 'Long centre line',
  LeftPenaltyStretch: 'Area front −x',
  RightPenaltyStretch: 'Area front +x',
  LeftFieldLeftPenaltyStretch: 'Area side −x, −y',
  LeftFieldRightPenaltyStretch: 'Area side −x, +y',
  RightFieldLeftPenaltyStretch: 'Area side +x, +y',
  RightFieldRightPenaltyStretch: 'Area side +x, −y',
  CenterCircle: 'Centre circle',
};

/** A field's own lines keep their names. */
export const lineTitle = (name: string): string => LINES[name] ?? name;

/** "corner left top" to "Corner left top" */
export const pointTitle = (name: string): string => name.charAt(0).toUpperCase() + name.slice(1);
