"""What a case will model and cost, told and drawn before anything is solved."""
