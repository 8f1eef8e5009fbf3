"""Parts of scripts/results_campaign.py: how a results file is changed, and how a command is watched."""
