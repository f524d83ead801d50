"""What more than one part of the machine is made of: streams, pipelines, arithmetic."""
