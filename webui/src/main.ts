// SPDX-License-Identifier: Apache-2.0
import { createApp } from 'vue';
import App from './App.vue';
import { tellFullText } from './shell/fullText';
import { followAccess } from './state/access';
import { connect } from './state/live';
import { followTheme } from './state/theme';
import './styles/tokens.css';
import './styles/base.css';

followTheme();
connect();
followAccess();
addEventListener('pointerover', tellFullText);
createApp(App).mount('#app');
