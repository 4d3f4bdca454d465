// SPDX-License-Identifier: Apache-2.0
import { createApp } from 'vue';
import App from './App.vue';
import { followAccess } from './state/access';
import { tellAway } from './state/away';
import { connect } from './state/live';
import { keepPanel } from './state/offline';
import { followPanelVersion } from './state/panelVersion';
import { followTheme } from './state/theme';
import './styles/tokens.css';
import './styles/base.css';

followTheme();
connect();
followAccess();
tellAway();
followPanelVersion();
keepPanel();
createApp(App).mount('#app');
