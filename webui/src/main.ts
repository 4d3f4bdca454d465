// SPDX-License-Identifier: Apache-2.0
import { createApp } from 'vue';
import App from './App.vue';
import { tellFullText } from './shell/fullText';
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
addEventListener('pointerover', tellFullText);
tellAway();
followPanelVersion();
keepPanel();
createApp(App).mount('#app');
