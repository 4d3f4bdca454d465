// SPDX-License-Identifier: Apache-2.0
// The attacks, one module each: {name, about, run(context)}. `run` continues until context.isOver(); the context is
// defined in strangers.mjs. New attacks must be added to this list.
import backups from './attacks/backups.mjs';
import files from './attacks/files.mjs';
import gvsp from './attacks/gvsp.mjs';
import http from './attacks/http.mjs';
import otherComputer from './attacks/other_computer.mjs';
import otherSubnet from './attacks/other_subnet.mjs';
import ports from './attacks/ports.mjs';
import referee from './attacks/referee.mjs';
import sessions from './attacks/sessions.mjs';
import settings from './attacks/settings.mjs';
import slowReaders from './attacks/slow_readers.mjs';
import tracker from './attacks/tracker.mjs';
import vision from './attacks/vision.mjs';

export const ATTACKS = [gvsp, vision, otherComputer, otherSubnet, tracker, referee, ports, http, slowReaders, sessions, backups, files, settings];
