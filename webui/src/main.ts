// SPDX-License-Identifier: Apache-2.0
import { createApp } from 'vue';
import App from './App.vue';
import { followAccess } from './state/access';
import { connect } from './state/live';
import { followTheme } from './state/theme';
import './styles/tokens.css';
import './styles/base.css';

followTheme();
connect();
followAccess();
createApp(App).mount('#app');
