// SPDX-License-Identifier: Apache-2.0
// Selects the page by the address after the hash, "#/camera/1", so that any file server can serve the panel.
import { computed, ref, type Component } from 'vue';
import type { IconName } from './components/icons';
import { lazyPage } from './lazyPage';
import OverviewPage from './pages/overview/OverviewPage.vue';

export interface Page {
  name: string;
  title: string;
  icon: IconName;
  component: Component;
  /** Not in the rail; other pages link to it. */
  isAside?: boolean;
  /** Fills the screen, without the rail and the bar. */
  isAlone?: boolean;
}

/** The pages in the order of the rail; the first is the start page. The others are loaded when they are opened. */
export const pages: readonly [Page, ...Page[]] = [
  { name: 'overview', title: 'Overview', icon: 'overview', component: OverviewPage },
  { name: 'camera', title: 'Camera', icon: 'camera', component: lazyPage(() => import('./pages/camera/CameraPage.vue')) },
  { name: 'colours', title: 'Colours', icon: 'palette', component: lazyPage(() => import('./pages/colours/ColoursPage.vue')) },
  { name: 'calibration', title: 'Calibration', icon: 'target', component: lazyPage(() => import('./pages/calibration/CalibrationPage.vue')) },
  { name: 'settings', title: 'Settings', icon: 'sliders', component: lazyPage(() => import('./pages/settings/SettingsPage.vue')) },
  { name: 'field', title: 'Field', icon: 'network', component: lazyPage(() => import('./pages/field/FieldPage.vue')) },
  { name: 'recordings', title: 'Recordings', icon: 'record', component: lazyPage(() => import('./pages/recordings/RecordingsPage.vue')) },
  { name: 'diagnostics', title: 'Diagnostics', icon: 'activity', component: lazyPage(() => import('./pages/diagnostics/DiagnosticsPage.vue')) },
  { name: 'kiosk', title: 'Kiosk', icon: 'fullscreen', component: lazyPage(() => import('./pages/kiosk/KioskPage.vue')), isAside: true, isAlone: true },
  { name: 'api', title: 'API', icon: 'link', component: lazyPage(() => import('./pages/api/ApiPage.vue')), isAside: true },
];

const hash = ref(location.hash);
addEventListener('hashchange', () => { hash.value = location.hash; });

const parts = computed(() => hash.value.replace(/^#\/?/, '').split('/'));
export const page = computed(() => pages.find(({ name }) => name === parts.value[0]) ?? pages[0]);
/** The first part after the page's name, such as a camera's number. */
export const pageArgument = computed(() => parts.value[1] ?? '');

/** Everything after the page's name, such as a place in the settings. */
export const pagePath = computed(() => parts.value.slice(1).join('/'));

export const link = (name: string, argument?: string | number) =>
  argument === undefined ? `#/${name}` : `#/${name}/${argument}`;
